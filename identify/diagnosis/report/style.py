"""What the pages of a diagnosis add to the style of reports: before is vermilion, after is blue."""

MORE_STYLE = """
svg .before { stroke: var(--residual); stroke-width: 1.6px; }
svg .after { stroke: var(--predicted); stroke-width: 1.6px; }
svg .thin { stroke-width: 0.9px; }
svg .cloud { stroke: var(--residual); stroke-opacity: 0.22; stroke-width: 2.6px; }
svg .cloudafter { stroke: var(--predicted); stroke-opacity: 0.22; stroke-width: 2.6px; }
svg .barbefore { fill: var(--residual); } svg .barafter { fill: var(--predicted); }
svg .heat { fill: var(--residual); } svg .one { stroke: var(--ink); stroke-width: 1; stroke-dasharray: 3 3; }
svg .name { font-size: 12px; }
.grid + .scroll { margin-top: 14px; } ul.verdict + .grid { margin-top: 14px; }
figure h3 { margin: 8px 0 0; font-size: 12px; }
"""
