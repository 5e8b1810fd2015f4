# SPDX-License-Identifier: Apache-2.0
"""A scatter plot as SVG: one colour a series, a label at each point."""
import math
from xml.sax.saxutils import escape

COLOURS = ("#2563eb", "#dc2626", "#059669", "#d97706", "#7c3aed")
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 900, 420, 62, 20, 40, 48


def log_ticks(low, high):
    values = [m * 10.0**e for e in range(-3, 7) for m in (1, 2, 5)]
    return [v for v in values if low <= v <= high]


def even_ticks(low, high):
    step = next(s for s in (1, 2, 5, 10, 20, 50) if (high - low) / s <= 7)
    return [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def scatter(title, x_label, y_label, series):
    """series: [(name, [(x, y, label), ...])]; x on a logarithmic axis, y on an even one."""
    points = [p for _, ps in series for p in ps]
    x_low, x_high = min(p[0] for p in points) / 1.3, max(p[0] for p in points) * 1.6
    y_low, y_high = min(p[1] for p in points) - 1.5, max(p[1] for p in points) + 1.5

    def x_of(v):
        return LEFT + (math.log(v) - math.log(x_low)) / (math.log(x_high) - math.log(x_low)) * (WIDTH - LEFT - RIGHT)

    def y_of(v):
        return HEIGHT - BOTTOM - (v - y_low) / (y_high - y_low) * (HEIGHT - TOP - BOTTOM)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
           f'<text x="{LEFT}" y="22" font-size="15" font-weight="bold">{escape(title)}</text>']
    for v in log_ticks(x_low, x_high):
        x = x_of(v)
        out.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#e2e8f0"/>')
        out.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle" fill="#475569">{v:g}</text>')
    for v in even_ticks(y_low, y_high):
        y = y_of(v)
        out.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#e2e8f0"/>')
        out.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end" fill="#475569">{v:g}</text>')
    out.append(f'<path d="M{LEFT} {TOP}V{HEIGHT - BOTTOM}H{WIDTH - RIGHT}" fill="none" stroke="#475569"/>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2:.0f}" y="{HEIGHT - 10}" text-anchor="middle">{escape(x_label)}</text>')
    middle = (TOP + HEIGHT - BOTTOM) / 2
    out.append(f'<text transform="translate(16 {middle:.0f}) rotate(-90)" text-anchor="middle">{escape(y_label)}</text>')
    for k, (name, ps) in enumerate(series):
        colour = COLOURS[k % len(COLOURS)]
        for x, y, label in ps:
            out.append(f'<circle cx="{x_of(x):.1f}" cy="{y_of(y):.1f}" r="5" fill="{colour}"/>')
            out.append(f'<text x="{x_of(x) + 9:.1f}" y="{y_of(y) + 4:.1f}" fill="{colour}">{escape(label)}</text>')
        out.append(f'<text x="{WIDTH - RIGHT - 10}" y="{TOP + 18 + 18 * k}" text-anchor="end" fill="{colour}">● {escape(name)}</text>')
    return "\n".join(out) + "\n</svg>\n"
