"""How a report looks: one style sheet, light and dark, for screen and paper.

Lines differ in colour and width: blue, orange and vermilion of Okabe and Ito, told apart by colour-blind
readers too, and a thin line over a broad one where two agree. Before is vermilion, after is blue.
"""

STYLE = """
:root { color-scheme: light dark; --ground: #ffffff; --ink: #1c1f23; --faint: #5c646e; --rule: #d6dae0;
  --panel: #f6f7f9; --measured: #e69f00; --predicted: #0067a5; --residual: #c44e00; --band: #8a94a0;
  --good: #00694e; --middling: #8a5a00; --bad: #b02a00; }
@media (prefers-color-scheme: dark) { :root { --ground: #15181c; --ink: #e6e8eb; --faint: #a2abb6;
  --rule: #363c45; --panel: #1d2126; --measured: #b87f00; --predicted: #6cc2f5; --residual: #ff8b4d;
  --band: #7b8694; --good: #4fc8a0; --middling: #f0b429; --bad: #ff8066; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 16px 24px 40px; max-width: 1500px; background: var(--ground);
  color: var(--ink); font: 14px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; margin: 4px 0 2px; } h2 { font-size: 19px; margin: 30px 0 6px;
  border-bottom: 1px solid var(--rule); padding-bottom: 3px; } h3 { font-size: 15px; margin: 16px 0 4px; }
p { margin: 5px 0; max-width: 110ch; } p.note, figcaption small { color: var(--faint); }
nav a { margin-right: 14px; } a { color: var(--predicted); }
ul.verdict { margin: 8px 0; padding: 10px 14px 10px 32px; background: var(--panel); border-radius: 6px; }
ul.verdict li { max-width: 115ch; } ul.verdict li:first-child { font-weight: 600; }
.grid { display: grid; gap: 10px 20px; align-items: start; }
.two { grid-template-columns: repeat(auto-fill, minmax(min(560px, 100%), 1fr)); }
.three { grid-template-columns: repeat(auto-fill, minmax(min(390px, 100%), 1fr)); }
figure { margin: 0; min-width: 0; } figcaption { font-weight: 600; font-size: 13px; }
figcaption small { font-weight: 400; font-size: 12px; margin-left: 8px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { padding: 2px 10px 2px 0; text-align: right; white-space: nowrap; }
th { border-bottom: 1px solid var(--rule); color: var(--faint); font-weight: 600; }
.tables th, .tables td { padding-right: 8px; }
th:first-child, td:first-child, .words { text-align: left; }
td.good { color: var(--good); }
td.middling { color: var(--middling); } td.bad { color: var(--bad); font-weight: 600; }
td svg { display: block; width: 140px; height: 16px; }
figure svg { display: block; width: 100%; height: auto; overflow: visible; }
code { font-size: 13px; overflow-wrap: anywhere; }
svg text { font: 11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: var(--ink); }
svg .tick { fill: var(--faint); } svg .middle { text-anchor: middle; } svg .end { text-anchor: end; }
svg .frame { fill: var(--panel); stroke: var(--rule); } svg .grid { stroke: var(--rule); }
svg path { fill: none; stroke-linejoin: round; stroke-linecap: round; vector-effect: non-scaling-stroke; }
svg .measured { stroke: var(--measured); stroke-width: 3.2px; }
svg .predicted { stroke: var(--predicted); stroke-width: 1.3px; }
svg .residual { stroke: var(--residual); stroke-width: 1px; }
svg .dots { stroke: var(--measured); stroke-width: 2.6px; }
svg .band, svg .prior { fill: var(--band); fill-opacity: 0.28; stroke: none; }
svg .bandkey { stroke: var(--band); stroke-opacity: 0.4; stroke-width: 9px; stroke-linecap: butt; }
svg .sure { fill: var(--predicted); fill-opacity: 0.3; stroke: none; }
svg .zero { stroke: var(--faint); stroke-width: 1; }
svg .interval { stroke: var(--predicted); stroke-width: 4; }
svg .value { fill: var(--predicted); } svg .share { fill: var(--residual); }
svg .before { stroke: var(--residual); stroke-width: 1.6px; }
svg .after { stroke: var(--predicted); stroke-width: 1.6px; }
svg .thin { stroke-width: 0.9px; }
svg .cloud { stroke: var(--residual); stroke-opacity: 0.22; stroke-width: 2.6px; }
svg .cloudafter { stroke: var(--predicted); stroke-opacity: 0.22; stroke-width: 2.6px; }
svg .barbefore { fill: var(--residual); } svg .barafter { fill: var(--predicted); }
svg .moment { fill: var(--measured); fill-opacity: 0.3; stroke: none; }
svg .momentkey { stroke: var(--measured); stroke-opacity: 0.4; stroke-width: 9px; }
svg .heat { fill: var(--residual); } svg .one { stroke: var(--ink); stroke-width: 1; stroke-dasharray: 3 3; }
svg .name { font-size: 12px; }
.grid + .scroll { margin-top: 14px; } ul.verdict + .grid { margin-top: 14px; }
figure h3 { margin: 8px 0 0; font-size: 12px; }
.chapter > h1 { margin: 44px 0 0; padding-top: 10px; border-top: 3px solid var(--rule); }
nav.contents ol { margin: 10px 0; padding-left: 22px; } nav.contents li { margin: 2px 0; }
nav.contents a.part { font-weight: 600; } nav.contents a { display: inline-block; }
@media print { :root { --ground: #ffffff; --ink: #000000; --faint: #444444; --rule: #cccccc; --panel: #ffffff;
  --measured: #e69f00; --predicted: #0067a5; --residual: #c44e00; --band: #8a94a0; color-scheme: light; }
  body { max-width: none; padding: 0; font-size: 11px; } nav { display: none; }
  nav.contents { display: block; }
  .chapter { break-before: page; } .chapter > h1 { margin-top: 0; border-top: none; }
  .two { grid-template-columns: 1fr 1fr; } .three { grid-template-columns: 1fr 1fr 1fr; }
  svg text { font-size: 12px; } .two figure svg { height: 190px; } td svg { width: 130px; }
  figure, tr, p, li, ul.verdict { break-inside: avoid; } h1, h2, h3, h2 + p { break-after: avoid; }
  figure h3 + svg { height: auto !important; } table { font-size: 10px; }
  @page { size: A4 landscape; margin: 12mm; } }
"""
