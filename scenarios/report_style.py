"""How a report looks: on a screen of any width, and in print."""

STYLE = """
:root { color-scheme: light; --ink: #1c2430; --soft: #5a6675; --rule: #dde3ea; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 1rem; color: var(--ink); background: #fff;
  font: 15px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.5rem; margin: 0; }
h2 { font-size: 1.1rem; margin: 1.6rem 0 .5rem; border-bottom: 1px solid var(--rule); padding-bottom: .2rem; }
header p { margin: .3rem 0 0; color: var(--soft); }
.badge { display: inline-block; padding: .05em .55em; border-radius: .8em; font-size: .8rem; font-weight: 600;
  vertical-align: middle; background: #e7ebf0; color: #37414d; white-space: nowrap; }
.badge.achieved, .badge.completed { background: #d5efe1; color: #11603c; }
.badge.dropped, .badge.degraded { background: #fbe6c4; color: #7a4a05; }
.badge.missed, .badge.failed, .badge.standby, .badge.not-finished { background: #fad4da; color: #8f1230; }
table { border-collapse: collapse; min-width: min(100%, 36rem); }
th { text-align: left; font-size: .8rem; color: var(--soft); font-weight: 600; }
th, td { padding: .3rem .7rem .3rem 0; vertical-align: top; border-bottom: 1px solid var(--rule);
  overflow-wrap: break-word; }
td { font-variant-numeric: tabular-nums; }
td:is([data-head="goal"], [data-head="at"], [data-head="plan"], [data-head="occurred"], [data-head="noticed"],
  [data-head="recovered"]) { white-space: nowrap; }
.reason, .note { color: var(--soft); }
header p.broken { color: #a3123a; font-weight: 600; }
.note { font-size: .85rem; margin: .2rem 0 .5rem; }
.wide { overflow-x: auto; }
.wide svg { display: block; width: 100%; min-width: 860px; height: auto; }
svg text { font: 10px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; fill: var(--ink); }
svg text.label { fill: #fff; }
svg text.label.dark { fill: #10151c; }
svg text.lane { font-weight: 600; fill: #37414d; paint-order: stroke; stroke: #fff; stroke-width: 3px; }
svg text.tick { font-size: 9px; fill: var(--soft); paint-order: stroke; stroke: #fff; stroke-width: 3px; }
svg line.grid { stroke: #e6eaef; stroke-width: .7; }
svg rect.planned { opacity: .42; }
svg line.fault, svg line.seen { stroke: #e11d48; stroke-width: 1.3; }
svg line.fault { stroke-dasharray: 4 3; }
svg line.plan { stroke: #0f766e; stroke-width: 1.3; }
svg text.fault, svg text.seen { fill: #b3123a; font-weight: 600; }
svg text.plan { fill: #0b5a54; font-weight: 600; }
figure { margin: .4rem 0; }
figcaption { font-size: .8rem; color: var(--soft); }
.key { font-weight: 600; margin-left: .6em; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 400px), 1fr)); gap: .2rem 1rem; }
.plots svg { display: block; width: 100%; height: auto; }
.plots svg text.tick { font-size: 12px; }
.images { margin-bottom: .8rem; display: grid;
  grid-template-columns: repeat(auto-fill, minmax(130px, 1fr)); gap: .5rem; }
.frame { position: relative; }
.frame svg { position: absolute; inset: 0; width: 100%; height: 100%; }
.frame rect { fill: none; stroke-width: 1.4px; vector-effect: non-scaling-stroke; }
.images figure { margin: 0; }
.images img { width: 100%; display: block; background: #000; border-radius: 3px; }
.events { list-style: none; margin: 0; padding: 0; font-size: .9rem; }
.events li { padding: .15rem 0; overflow-wrap: anywhere; }
.events time { font-variant-numeric: tabular-nums; color: var(--soft); margin-right: .6em; }
.events .warn { color: #7a4a05; }
.events .error { color: #a3123a; }
@media (max-width: 640px) {
  thead { display: none; }
  tr { display: block; padding: .45rem 0; border-bottom: 1px solid var(--rule); }
  td { display: inline-block; border: 0; padding: .05rem 0; margin-right: .8em; }
  td:empty { display: none; }
  .images { grid-template-columns: repeat(auto-fill, minmax(100px, 1fr)); }
  td[data-head="goal"]::before { content: none !important; }
  td[data-head]:not([data-head=""])::before { content: attr(data-head) ": "; color: var(--soft); font-size: .8rem; }
}
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  .wide { overflow: visible; }
  .wide svg { min-width: 0; }
  figure, tr, li, .wide { break-inside: avoid; }
  h2, .note, thead { break-after: avoid; }
  .note, header p { break-inside: avoid; }
  .plots { grid-template-columns: 1fr 1fr; }
  .images { grid-template-columns: repeat(8, 1fr); gap: .3rem; }
  .images figcaption { font-size: 6.5pt; line-height: 1.25; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
"""
