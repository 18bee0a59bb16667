"""Commands on their way: numbered, journalled, acknowledged, confirmed from telemetry, repeated, or given up."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Literal

from executive.conditions import Parameters, Telemetry, Watch, settled
from executive.journal import Journal
from executive.port import Acknowledgement, Command, Plant
from executive.sends import Confirmation, Send

Progress = Literal["pending", "confirmed", "refused", "silent"]


class CommandLink:
    """The only sender of commands: gives them their numbers, and keeps what was said of those still awaited.

    `forbids`: says of a command's name why it must not be sent any more, None when it may; without it all may. One that
    must not is answered as if it were refused.
    """

    def __init__(self, plant: Plant, journal: Journal, forbids: Callable[[str], str | None] | None = None) -> None:
        self._plant = plant
        self._journal = journal
        self._forbids = forbids
        self._sent = 0
        self._answers: dict[int, Acknowledgement | None] = {}

    def send(self, sends: Iterable[Send], parameters: Parameters, owner: str, now: int) -> tuple[int, ...]:
        """Send commands at once; `owner` is the token (or what else) that they serve. Returns their numbers."""
        numbers = []
        for send in sends:
            self._sent += 1
            arguments = {name: settled(value, parameters) for name, value in send.arguments.items()}
            entry = {"id": self._sent, "name": send.name, "arguments": arguments, "token": owner}
            numbers.append(self._sent)
            if self._forbids is not None and (reason := self._forbids(send.name)) is not None:
                self._journal.write(now, "command.withheld", entry | {"reason": reason})
                self._answers[self._sent] = Acknowledgement(self._sent, False, f"not sent: {reason}")
                continue
            self._journal.write(now, "command.sent", entry)
            self._answers[self._sent] = None
            self._plant.send(Command(self._sent, send.name, arguments))
        return tuple(numbers)

    def is_forbidden(self, name: str) -> bool:
        """Whether a command of that name would not be sent."""
        return self._forbids is not None and self._forbids(name) is not None

    def acknowledged(self, answers: Iterable[Acknowledgement], now: int) -> None:
        """Take in what receiving terminals said. Journalled whether or not anybody still waits for it."""
        for answer in answers:
            entry = {"id": answer.command_id, "accepted": answer.accepted, "reason": answer.reason}
            self._journal.write(now, "command.acknowledged", entry)
            if answer.command_id in self._answers:
                self._answers[answer.command_id] = answer

    def answer(self, number: int) -> Acknowledgement | None:
        """What was said of a command that is awaited; None so far."""
        return self._answers.get(number)

    def timed_out(self, numbers: Iterable[int], now: int) -> None:
        """Journal that no proof came in time."""
        for number in numbers:
            self._journal.write(now, "command.timeout", {"id": number})

    def forget(self, numbers: Iterable[int]) -> None:
        """Nobody waits for these any more."""
        for number in numbers:
            self._answers.pop(number, None)


class Transmission:
    """Some commands sent together until they are proven by their `Confirmation`, or given up.

    Only telemetry observed after a try proves it: whoever asks for progress asks once an observation, before sending.
    """

    def __init__(
        self,
        link: CommandLink,
        sends: tuple[Send, ...],
        confirmation: Confirmation,
        parameters: Parameters,
        owner: str,
    ) -> None:
        self._link = link
        self._sends = sends
        self._parameters = parameters
        self._owner = owner
        bound = tuple(c.bound_to(parameters) for c in confirmation.conditions)
        self.confirmation = replace(confirmation, conditions=bound)
        self.tries = 0
        self._retries = confirmation.retries
        self._numbers: tuple[int, ...] = ()
        self._sent_at = 0
        self._watch = Watch((), 0, {})

    def send(self, telemetry: Telemetry, now: int) -> None:
        """Send them, for the first time or again."""
        self._link.forget(self._numbers)
        self.tries += 1
        self._sent_at = now
        self._watch = Watch(self.confirmation.conditions, self.confirmation.persistence, telemetry)
        self._numbers = self._link.send(self._sends, self._parameters, self._owner, now)

    def progress(self, telemetry: Telemetry, now: int) -> Progress:
        """What is known of the latest try at this observation."""
        answers = [self._link.answer(number) for number in self._numbers]
        if any(answer is not None and not answer.accepted for answer in answers):
            return "refused"
        if self.confirmation.conditions:
            if self._watch.update(telemetry, now):
                return "confirmed"
        elif all(answer is not None for answer in answers):
            return "confirmed"
        return "silent" if now >= self._sent_at + self.confirmation.within else "pending"

    def follow(self, telemetry: Telemetry, now: int) -> Progress:
        """`progress`, with what it leads to: a try that failed is repeated as long as there are retries left.

        The answer is "refused" or "silent" only when the last retry failed.
        """
        progress = self.progress(telemetry, now)
        if progress in ("pending", "confirmed"):
            return progress
        if progress == "silent":
            self._link.timed_out(self._numbers, now)
        if self.tries > self._retries:
            return progress
        self.send(telemetry, now)
        return "pending"

    def due(self, now: int) -> int:
        """The next second at which waiting alone changes the answer."""
        proof = self._watch.due(now)
        late = self._sent_at + self.confirmation.within
        return late if proof is None else min(late, proof)

    def complaint(self, progress: Progress, telemetry: Telemetry) -> str:
        """Why it was given up, for people."""
        names = ", ".join(send.name for send in self._sends) or "no command"
        tries = f"{self.tries} {'try' if self.tries == 1 else 'tries'}"
        if progress == "refused":
            refusals = [a for n in self._numbers if (a := self._link.answer(n)) is not None and not a.accepted]
            return f"{names} refused after {tries}: {refusals[0].reason or 'no reason given'}"
        missing = self._watch.first_failing(telemetry) if self.confirmation.conditions else "no acknowledgement"
        return f"{names} not confirmed within {self.confirmation.within} s, {tries}: {missing}"

    @property
    def is_answered(self) -> bool:
        """Whether any command of the latest try has been acknowledged."""
        return any(self._link.answer(number) is not None for number in self._numbers)

    def serve(self, owner: str) -> None:
        """What is sent from now on is sent for that token."""
        self._owner = owner

    def again(self, telemetry: Telemetry, now: int) -> None:
        """Send them once more after a recovery, with as many retries as at first."""
        self.tries = 0
        self.send(telemetry, now)

    def no_more_tries(self) -> None:
        """What fails from now on is given up at once."""
        self._retries = 0

    def close(self) -> None:
        """Wait for nothing any more."""
        self._link.forget(self._numbers)
