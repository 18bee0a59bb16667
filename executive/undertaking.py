"""The commands for a token's start or end until they are proven: repeated, sent again after a recovery, or given up."""

from __future__ import annotations

from executive.commands import CommandLink, Progress, Transmission
from executive.conditions import Parameters, Telemetry
from executive.recovery import Case, FaultProtection
from executive.sends import Conclusion, Confirmation, Send


class Undertaking:
    """A transmission, and the case that is opened when it is not proven. A case is judged by sending once more."""

    def __init__(
        self,
        link: CommandLink,
        protection: FaultProtection,
        sends: tuple[Send, ...],
        confirmation: Confirmation,
        parameters: Parameters,
        owner: str,
    ) -> None:
        self._transmission = Transmission(link, sends, confirmation, parameters, owner)
        self._protection = protection
        self._parameters = parameters
        self._owner = owner
        self._case: Case | None = None
        self._sent_again = False
        self._failed: Progress = "pending"
        self._words = ""
        self._concluded: Conclusion | None = None

    def send(self, telemetry: Telemetry, now: int) -> None:
        """Send the commands for the first time."""
        self._transmission.send(telemetry, now)

    def follow(self, telemetry: Telemetry, now: int) -> Progress:
        """What is known at this observation: "refused" or "silent" only when nothing is left to try."""
        case = self._case
        if case is not None and case.stage == "given up":
            return self._failed
        if case is not None and not self._is_judging(case, telemetry, now):
            return "pending"
        progress = self._transmission.follow(telemetry, now)
        if progress == "pending":
            return progress
        if progress == "confirmed":
            if case is not None:
                case.recovered(now)
            return progress
        return self._recover(progress, telemetry, now)

    def complaint(self) -> str:
        """Why it was given up, for people."""
        return self._words

    @property
    def conclusion(self) -> Conclusion | None:
        """What is concluded from its failure."""
        return self._concluded if self._case is None else self._case.conclusion

    def due(self, now: int) -> int | None:
        """The next second at which waiting alone changes the answer; None while a recovery is under way."""
        if self._case is None or (self._case.stage == "judging" and self._sent_again):
            return self._transmission.due(now)
        return now + 1 if self._case.stage == "judging" else None

    def serve(self, owner: str) -> None:
        """What is sent from now on is sent for that token."""
        self._owner = owner
        self._transmission.serve(owner)

    def no_more_tries(self) -> None:
        """What fails from now on is given up at once."""
        self._transmission.no_more_tries()

    def close(self) -> None:
        """Wait for nothing any more."""
        self._transmission.close()
        if self._case is not None and self._case.is_open:
            self._case.abandon()

    def _is_judging(self, case: Case, telemetry: Telemetry, now: int) -> bool:
        """Whether the recovery is done and what was sent after it may be asked for."""
        if case.stage != "judging":
            self._sent_again = False
            return False
        if not self._sent_again:
            self._sent_again = True
            self._transmission.again(telemetry, now)
            return False
        return True

    def _recover(self, progress: Progress, telemetry: Telemetry, now: int) -> Progress:
        self._failed, self._sent_again = progress, False
        self._words = self._transmission.complaint(progress, telemetry)
        if self._case is None:
            kind = "refused" if progress == "refused" else "unconfirmed"
            confirmation = self._transmission.confirmation
            self._concluded = confirmation.conclusion
            if confirmation.unanswered is not None and not self._transmission.is_answered:
                self._concluded = confirmation.unanswered
            self._case = self._protection.suspect(self._concluded, kind, self._parameters, self._owner, telemetry, now)
        else:
            self._case.persists(telemetry, now)
        return progress if self._case is None or not self._case.is_open else "pending"
