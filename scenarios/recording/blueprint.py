"""The layout a recording opens with: tabs Mission, Attitude, Power, Camera, Plan network, Events, and of channels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from scenarios.recording.boards import FAULTS_PATH, GOALS_PATHS, HEADER_PATH
from scenarios.recording.network import BOUNDS, COLUMNS, NETWORK, STEP_X, STEP_Y
from scenarios.recording.scene import CAMERA_IMAGE, WORLD, Scene
from scenarios.recording.stream import TIMELINE
from scenarios.recording.telemetry import Panel

LOG = "/log"
CAMERA_LOG = "/log/camera"
SITUATION = "/situation"
CHASE = "/camera/chase"
CHASE_CAPTION = "/camera/chase/caption"
CAMERA_FALLBACK = "/camera/micas"
LANES_A_TAB = 7
_LEVELS = ("DEBUG", "INFO", "WARN", "ERROR")
_GOALS = ("Goals; amber: begun, green: achieved", "Goals; orange: dropped, red: missed")
_LANE_HEIGHT, _HEADER_HEIGHT, _VIEWS_HEIGHT = 71.0, 142.0, 810.0
_LEGEND = 0.08  # of the mission, kept free at the right of plots for their legends
_LONG_LEGEND = 0.16  # the same for the plot of bounds
_MARGIN = 0.025  # of the mission at either end, so that the labels of blocks and axes there fit


def camera_path(scene: Scene) -> str:
    """Where the images of the science camera go: into the frustum of the 3D scene when there is one."""
    return CAMERA_IMAGE if scene.camera is not None else CAMERA_FALLBACK


class Layout:
    """Builds the blueprint. `start`, `end`: the mission in simulation seconds; every view opens on all of it."""

    def __init__(self, start: int, end: int) -> None:
        def axis(right: float) -> rrb.TimeAxis:
            bound, length = rrb.TimeRangeBoundary.absolute, end - start
            first, last = bound(seconds=start - _MARGIN * length), bound(seconds=end + right * length)
            return rrb.TimeAxis(view_range=rr.TimeRange(start=first, end=last))

        self._axis, self._axis_of_plots, self._axis_of_bounds = axis(_MARGIN), axis(_LEGEND), axis(_LONG_LEGEND)

    def build(
        self,
        scene: Scene,
        lane_paths: Sequence[str],
        panels: Sequence[Panel],
        power_lanes: Sequence[str],
        camera_lanes: Sequence[str],
    ) -> Any:
        """The whole layout; paths are those of the lanes' entities."""
        others = list(dict.fromkeys(p.tab for p in panels if p.tab not in ("Attitude", "Power")))
        tabs = [
            *self._mission(lane_paths),
            self._attitude(scene, panels),
            *self._power(panels, power_lanes),
            self._camera(scene, camera_lanes),
            self._network(len(lane_paths)),
            self._events(),
            *(self._plots(tab, panels) for tab in others),
        ]
        return rrb.Blueprint(
            rrb.Tabs(*tabs, active_tab=0),
            rrb.TimePanel(timeline=TIMELINE, state="collapsed", play_state="paused"),
            rrb.SelectionPanel(state="hidden"),
            rrb.BlueprintPanel(state="hidden"),
        )

    def _mission(self, lane_paths: Sequence[str]) -> list[Any]:
        """As many tabs as the lanes need, with the header lane on top of each; goals, faults and events under them."""
        count = max(1, math.ceil(len(lane_paths) / LANES_A_TAB))
        size = max(1, math.ceil(len(lane_paths) / count))
        groups = [lane_paths[i * size : (i + 1) * size] for i in range(count)]
        tabs = []
        for number, group in enumerate(groups, 1):
            chart = rrb.StateTimelineView(
                origin="/mission",
                contents=[HEADER_PATH, *group],
                name="Plan against execution: each timeline shows planned earliest / executed / planned latest",
                time_view=self._axis,
            )
            below = rrb.Horizontal(
                *(self._states(path, name) for path, name in zip(GOALS_PATHS, _GOALS, strict=True)),
                self._states(FAULTS_PATH, "Faults, from injection to recovery"),
                self._log("What happened", _LEVELS[1:]),
                column_shares=[1, 1, 1.1, 1.6],
            )
            lanes = _LANE_HEIGHT * len(group) + _HEADER_HEIGHT
            name = "Mission" if number == 1 else f"Mission {number}"
            tabs.append(rrb.Vertical(chart, below, row_shares=[lanes, _VIEWS_HEIGHT - lanes], name=name))
        return tabs

    def _states(self, path: str, name: str) -> Any:
        return rrb.StateTimelineView(origin=path, name=name, time_view=self._axis)

    def _attitude(self, scene: Scene, panels: Sequence[Panel]) -> Any:
        reach = scene.extent()
        eye = (1.7 * reach, -2.1 * reach, 1.15 * reach)
        world = rrb.Spatial3DView(
            origin=WORLD,
            name="Spacecraft among sky directions",
            background=rrb.Background(color=[4, 5, 10]),
            line_grid=False,
            eye_controls=rrb.EyeControls3D(position=eye, look_target=(0, 0, 0), eye_up=(0, 0, 1)),
        )
        views, shares = self._panel_views("Attitude", panels)
        if not views:
            return rrb.Horizontal(world, name="Attitude")
        return rrb.Horizontal(world, rrb.Vertical(*views, row_shares=shares), name="Attitude")

    def _power(self, panels: Sequence[Panel], lanes: Sequence[str]) -> list[Any]:
        views, shares = self._panel_views("Power", panels)
        if lanes:
            height = len(lanes) * _LANE_HEIGHT + 60
            left = (_VIEWS_HEIGHT - height) / max(1.0, sum(shares))
            views.append(self._lanes("What draws power: planned earliest / executed / planned latest", lanes))
            shares = [*(share * left for share in shares), height]
        return [rrb.Vertical(*views, row_shares=shares, name="Power")] if views else []

    def _camera(self, scene: Scene, lanes: Sequence[str]) -> Any:
        name = "Science camera at the cursor; orange: the target, blue: stars recognised"
        science = rrb.Spatial2DView(origin=camera_path(scene), name=name)
        chase = rrb.Spatial2DView(origin=CHASE, name="The spacecraft from outside, as simulated")
        log = self._log("Images", None, CAMERA_LOG, columns=["body"])
        images = rrb.Horizontal(science, chase, log, column_shares=[3, 3, 2])
        if not lanes:
            return rrb.Vertical(images, name="Camera")
        height = len(lanes) * _LANE_HEIGHT + 60
        chart = self._lanes("Camera: planned earliest / executed / planned latest", lanes)
        return rrb.Vertical(images, chart, row_shares=[_VIEWS_HEIGHT - height, height], name="Camera")

    def _network(self, lanes: int) -> Any:
        bounds = rrb.VisualBounds2D(x_range=(-2.0 * STEP_X, COLUMNS * STEP_X), y_range=(-STEP_Y, (lanes + 1) * STEP_Y))
        graph = rrb.GraphView(origin=NETWORK, name="Plan in force at the cursor", visual_bounds=bounds)
        funnels = rrb.TimeSeriesView(
            origin=BOUNDS,
            name="When each may start: earliest and latest, in minutes after the earliest that its plan first gave",
            axis_x=self._axis_of_bounds,
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        )
        return rrb.Vertical(graph, funnels, row_shares=[1.3, 1], name="Plan network")

    def _events(self) -> Any:
        page = rrb.TextDocumentView(origin=SITUATION, name="How things stand at the cursor")
        log = self._log("Events; level TRACE, of probes and acknowledgements, is left out", _LEVELS)
        return rrb.Horizontal(log, page, column_shares=[2, 1], name="Events")

    def _plots(self, tab: str, panels: Sequence[Panel]) -> Any:
        views, shares = self._panel_views(tab, panels)
        return rrb.Vertical(*views, row_shares=shares, name=tab)

    def _panel_views(self, tab: str, panels: Sequence[Panel]) -> tuple[list[Any], list[float]]:
        views, shares = [], []
        for panel in panels:
            if panel.tab != tab:
                continue
            if panel.state:
                views.append(self._states(panel.path, panel.title))
                shares.append((len(panel.channels) * 20 + 80) / 250)
            else:
                legend = rrb.PlotLegend(rrb.Corner2D.RightTop, visible=len(panel.channels) > 1)
                plot = rrb.TimeSeriesView(
                    origin=panel.path, name=panel.title, axis_x=self._axis_of_plots, plot_legend=legend
                )
                views.append(plot)
                shares.append(1.0 + min(0.5, 0.125 * (len(panel.channels) - 1)))
        return views, shares

    def _lanes(self, name: str, paths: Sequence[str]) -> Any:
        return rrb.StateTimelineView(origin="/mission", contents=list(paths), name=name, time_view=self._axis)

    def _log(
        self, name: str, levels: Sequence[str] | None, origin: str = LOG, columns: Sequence[str] = ("loglevel", "body")
    ) -> Any:
        hidden = [rrb.encodings.TimelineColumn(TIMELINE, visible=False)]
        shown = rrb.TextLogColumns(timeline_columns=hidden, text_log_columns=list(columns))
        rows = rrb.TextLogRows(filter_by_log_level=list(levels)) if levels else None
        return rrb.TextLogView(origin=origin, name=name, columns=shown, rows=rows)
