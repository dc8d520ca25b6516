#include "tools/report/style.h"

namespace orient {

// ok, weak and failed are told apart by word as well as by colour; patches by shape as well.
const std::string_view kReportStyle = R"(
:root { --ink: #22282f; --soft: #66707b; --line: #dfe3e8; --page: #ffffff; --panel: #f7f8fa;
  --ok: #2c7a57; --weak: #a86a00; --failed: #b3362b; --link: #1d5a9c;
  --matched: #1f62ad; --rejected: #c02d86; --missed: #8d97a3; --tie: #4f9d84; }
* { box-sizing: border-box; }
html { background: var(--page); color: var(--ink); -webkit-text-size-adjust: 100%; }
body { max-width: 1180px; margin: 0 auto; padding: 36px 28px 80px;
  font: 15px/1.5 "Source Sans 3", "Segoe UI", "Helvetica Neue", Helvetica, Arial, sans-serif;
  font-variant-numeric: tabular-nums; overflow-wrap: break-word; }
a { color: var(--link); text-decoration: none; } a:hover { text-decoration: underline; }
h1 { font-size: 28px; line-height: 1.2; font-weight: 600; margin: 0 0 4px; }
h2 { font-size: 19px; font-weight: 600; margin: 0 0 12px; }
h3 { font-size: 16px; font-weight: 600; margin: 24px 0 4px; }
h4 { font-size: 13px; font-weight: 600; color: var(--soft); margin: 16px 0 4px; }
section { margin-top: 40px; }
section.photo { border-top: 1px solid var(--line); padding-top: 24px; }
.program { color: var(--soft); margin: 0 0 2px; font-size: 13px; }
.facts, .note, figcaption { color: var(--soft); font-size: 13.5px; margin: 4px 0 12px; }
.up { float: right; font-size: 13px; font-weight: 400; margin-top: 4px; }
.tiles { display: flex; flex-wrap: wrap; gap: 12px; margin-top: 22px; }
.tile { flex: 1 1 112px; background: var(--panel); border: 1px solid var(--line);
  border-radius: 6px; padding: 12px 14px; border-top: 3px solid var(--line); }
.tile .value { font-size: 25px; font-weight: 600; line-height: 1.2; white-space: nowrap; }
.tile .value small { font-size: 15px; font-weight: 400; color: var(--soft); }
.tile .name, .tile-note { font-size: 12.5px; color: var(--soft); line-height: 1.35; }
.tile.ok { border-top-color: var(--ok); } .tile.ok .value { color: var(--ok); }
.tile.weak { border-top-color: var(--weak); } .tile.weak .value { color: var(--weak); }
.tile.failed { border-top-color: var(--failed); } .tile.failed .value { color: var(--failed); }
.tile.none .value { color: #b3bac2; }
.pill { display: inline-block; font-size: 12px; font-weight: 600; line-height: 1; padding: 4px 8px;
  border-radius: 10px; vertical-align: 2px; }
.pill.ok { color: var(--ok); background: #e3f2ea; }
.pill.weak { color: var(--weak); background: #fbefd9; }
.pill.failed { color: var(--failed); background: #fbe5e2; }
.pill.look { color: var(--link); background: #e4eef9; }
.concerns { list-style: none; margin: 0; padding: 0; border: 1px solid var(--line);
  border-radius: 6px; }
.concerns li { display: flex; gap: 14px; padding: 10px 14px; border-top: 1px solid var(--line); }
.concerns li:first-child { border-top: 0; }
.concerns .pill { flex: 0 0 62px; text-align: center; align-self: flex-start; margin-top: 2px; }
.concerns li > span:last-child { min-width: 0; }
.messages { margin: 0 0 12px; padding: 8px 14px 8px 32px; background: var(--panel);
  border-left: 3px solid var(--line); }
.messages.weak { border-left-color: var(--weak); }
.messages.failed { border-left-color: var(--failed); }
.wide { overflow-x: auto; margin: 0 0 12px; }
table { border-collapse: collapse; font-size: 13.5px; }
table.photos { width: 100%; }
th { text-align: left; font-weight: 600; color: var(--soft); font-size: 12.5px;
  vertical-align: bottom; border-bottom: 1px solid #b9c0c8; padding: 4px 14px 4px 0; }
td { padding: 4px 14px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td.n, th.n { text-align: right; } td.n { white-space: nowrap; }
table.photos td:first-child { overflow-wrap: anywhere; min-width: 184px; }
table.photos td:last-child { min-width: 170px; padding-right: 0; overflow-wrap: anywhere; }
th.n { white-space: nowrap; line-height: 1.3; }
table.photos td, table.photos th { padding-right: 12px; }
.more { color: var(--soft); white-space: nowrap; }
.mark-rejected { color: var(--rejected); } .mark-missing { color: var(--soft); }
figure { margin: 0 0 16px; } figure svg { display: block; width: 100%; height: auto; }
figcaption { margin: 6px 0 0; line-height: 1.6; }
figure img { max-width: 100%; height: auto; display: block; border: 1px solid var(--line); }
.columns { display: grid; grid-template-columns: minmax(0, 5fr) minmax(0, 6fr); gap: 0 32px; }
.key { white-space: nowrap; margin-right: 14px; }
.sw { display: inline-block; width: 16px; height: 10px; border: 1.5px solid; margin-right: 5px; }
.sw.ok { color: var(--ok); background: #e3f2ea; } .sw.weak { color: var(--weak);
  background: #fbefd9; } .sw.failed { color: var(--failed); background: #fbe5e2;
  border-style: dashed; }
.dot { display: inline-block; width: 8px; height: 8px; border-radius: 50%; margin-right: 5px; }
.dot.tie { background: var(--tie); } .dot.matched { background: var(--matched); } .dot.not_found { background: var(--missed); }
.cross { font-style: normal; font-weight: 700; color: var(--rejected); margin-right: 5px; }
.cross.plus { color: var(--ink); }
svg text { font-size: 12px; fill: var(--ink); }
svg .tick { font-size: 11px; fill: var(--soft); }
.sheet { fill: #fcfcfd; } .neat { fill: none; stroke: #b9c0c8; }
.grid { stroke: #e8ebef; fill: none; }
.fp { stroke-width: 1.5; } .fp-ok { fill: #2c7a5714; stroke: var(--ok); }
.fp-weak { fill: #a86a001f; stroke: var(--weak); }
.fp-failed { fill: #b3362b14; stroke: var(--failed); stroke-dasharray: 6 4; }
.label { paint-order: stroke; stroke: #ffffffd9; stroke-width: 3.5px; stroke-linejoin: round; }
.bar, .centre { stroke: var(--ink); fill: none; stroke-width: 1.3; }
.halo { stroke: #ffffffd9; stroke-width: 5; fill: none; }
.p-matched, .p-not_found, .p-not_visible { fill: none; stroke-linecap: round; }
.p-matched { stroke: var(--matched); stroke-width: var(--dot, 5px); }
.p-not_found { stroke: var(--missed); stroke-width: calc(0.8 * var(--dot, 5px)); }
.p-not_visible { stroke: #d3d8de; stroke-width: calc(0.6 * var(--dot, 5px)); }
.p-tie { fill: none; stroke-linecap: round; stroke: var(--tie);
  stroke-width: calc(0.7 * var(--dot, 5px)); }
.p-rejected { stroke: var(--rejected); stroke-width: 1.5; fill: none; }
.r-matched { stroke: var(--matched); stroke-width: 1.3; fill: none; }
.r-start { stroke: var(--matched); stroke-width: 3.4; stroke-linecap: round; fill: none; }
.r-rejected { stroke: var(--rejected); stroke-width: 1.3; fill: none; }
.cut { stroke-dasharray: 3 2.5; }
@media screen and (max-width: 760px) { .columns { display: block; } body { padding: 20px 14px; } }
@media print {
  @page { margin: 14mm; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  .up { display: none; } a { color: inherit; }
  .wide { overflow: visible; } table, .facts, figcaption { font-size: 8.5pt; }
  td, th { padding-right: 8px; }
  h2, h3, h4 { break-after: avoid; }
  figure, tr, table:not(.photos), .tile, .concerns li { break-inside: avoid; }
  section { margin-top: 7mm; } section.photo { break-before: page; border-top: 0; margin-top: 0; }
  figure.map svg { max-height: 120mm; }
  figure img { width: auto; max-height: 235mm; }
}
)";

}  // namespace orient
