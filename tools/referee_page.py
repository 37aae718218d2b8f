#!/usr/bin/env python3
"""The page of a referee's report: referee_page.py REPORT.json PAGE.html

One file that opens without a network: tables, the picture of error against time, failing pairs.
"""
import base64
import html
import io
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import matplotlib.ticker  # noqa: E402, F401

STYLE = """body{font:16px/1.45 sans-serif;margin:2em auto;max-width:88em;padding:0 1em}
.wide{overflow-x:auto}table{border-collapse:collapse;margin:1em 0;font-variant-numeric:tabular-nums}
td,th{padding:.2em .6em;border-bottom:1px solid #ddd;white-space:nowrap}th{vertical-align:bottom}
td,th{text-align:right}td:first-child,th:first-child{text-align:left}.bad{color:#a00;font-weight:bold}
.none{color:#999}pre{background:#f5f5f5;padding:.6em;overflow-x:auto;font-size:13px}img{max-width:100%}
.narrow{font-size:12px}.narrow td,.narrow th{padding:.2em .3em}.narrow th{white-space:normal;max-width:5em}"""
HEAD = ["asked", "answered", "faulty", "gap error, median", "largest", "time, median"]
FLOOR = 1e-18  # an error of 0 is drawn here
NOTHING = '<span class="none">–</span>'


def table(head, rows, kind=""):
    cells = lambda row, tag: "".join(f"<{tag}>{value}</{tag}>" for value in row)
    body = "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows)
    return f'<div class="wide"><table class="{kind}"><tr>{cells(head, "th")}</tr>{body}</table></div>'


def faults(number):
    return f'<span class="bad">{number}</span>' if number else "0"


def microseconds(tally):
    return f'{1e6 * tally["seconds_median"]:.2f} us' if tally["timed"] else NOTHING


def row(library):
    tally = library["families"]["all"]
    error = [f'{tally["gap_error_median"]:.1e}', f'{tally["gap_error_largest"]:.1e}'] if tally["gaps"] else [NOTHING] * 2
    return [html.escape(library["name"]), tally["asked"], tally["answered"], faults(tally["faulty"]), *error,
            microseconds(tally)]


def asked(report):
    return [library for library in report["libraries"] if library["families"].get("all", {}).get("asked")]


def names(report):
    return [html.escape(library["name"]) for library in asked(report)]


def png(figure):
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=130)
    return base64.b64encode(data.getvalue()).decode()


def picture(report):
    """A library is a line from its median error to its largest one, at its median time."""
    libraries = [library for library in asked(report) if library["families"]["all"]["gaps"]]
    figure, axes = plt.subplots(figsize=(9.5, 5.5), layout="constrained")
    colours = plt.get_cmap("tab20").colors
    markers = "osD^v<>P"
    for number, library in enumerate(libraries):
        tally = library["families"]["all"]
        time = 1e6 * tally["seconds_median"]
        low, high = (max(tally[f"gap_error_{which}"], FLOOR) for which in ("median", "largest"))
        colour, marker = colours[number % 20], markers[number % len(markers)]
        axes.plot([time, time], [low, high], color=colour, lw=1.5)
        axes.plot(time, low, marker, color=colour, ms=8, label=f'{library["name"]} ({tally["faulty"]} faulty)')
        axes.plot(time, high, "_", color=colour, ms=12, mew=2)
    axes.set(xscale="log", yscale="log", xlabel="median time of both moves and the question, us",
             ylabel="error of the gap, share of the larger diameter",
             title="Error against time: symbol the median error, dash the largest")
    axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.tick_params(axis="x", which="minor", labelsize=8)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=9)
    return f'<img alt="error against time" src="data:image/png;base64,{png(figure)}">'


def kinds(report):
    libraries = asked(report)
    found = sorted({kind for library in libraries for kind in library["families"]["all"]["kinds"]})
    rows = [[html.escape(kind)] + [faults(library["families"]["all"]["kinds"].get(kind, 0)) for library in libraries]
            for kind in found]
    return table(["kind of fault"] + names(report), rows, "narrow")


def by_family(report, cell):
    libraries = asked(report)
    families = sorted({name for library in libraries for name in library["families"]} - {"all"})
    rows = [[html.escape(name)] + [cell(library["families"][name]) if name in library["families"] else NOTHING
                                   for library in libraries] for name in families]
    return table(["family"] + names(report), rows, "narrow")


def failures(report):
    text = ""
    for number, failure in enumerate(report["failures"], 1):
        what = html.escape(f'{failure["library"]}: {failure["kind"]} ({failure["family"]})')
        text += (f'<details><summary>{number}. {what}</summary><p>{html.escape(failure["text"])}</p>'
                 f'<p>failures.jsonl, line {number}; failure_{number}.cpp, failure_{number}.c</p>'
                 f'<pre>{html.escape(json.dumps(failure["pair"]))}</pre></details>')
    return text or "<p>None.</p>"


def page(report):
    libraries = asked(report)
    parts = [f"<p>{report['questions']} questions, seed {report['seed']}, {report['seconds']:.0f} s. "
             "Each answer is judged in exact arithmetic; what a library does not offer is not asked. "
             "Errors are shares of the larger diameter. Times are those of all libraries in one process, in turns.</p>",
             table(["library"] + HEAD, [row(library) for library in libraries]),
             picture(report) if libraries else "", "<h2>Kinds of fault</h2>", kinds(report),
             "<h2>Faulty answers of those asked, by family</h2>",
             by_family(report, lambda tally: f'{faults(tally["faulty"])} / {tally["asked"]}'),
             "<h2>Median time, us, by family</h2>",
             by_family(report, lambda tally: microseconds(tally).removesuffix(" us")),
             "<h2>Largest error of the gap, by family</h2>",
             by_family(report, lambda tally: f'{tally["gap_error_largest"]:.0e}' if tally["gaps"] else NOTHING),
             "<h2>Failures, the first of each kind and family, made smaller</h2>", failures(report)]
    return ('<!doctype html><html lang="en"><meta charset="utf-8"><title>Referee</title>'
            f"<style>{STYLE}</style><h1>Referee of contact libraries</h1>{''.join(parts)}</html>\n")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        report = json.load(file)
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write(page(report))


if __name__ == "__main__":
    main()
