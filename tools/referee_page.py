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

STYLE = """body{font:16px/1.45 sans-serif;margin:2em auto;max-width:72em;padding:0 1em}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.25em .7em;border-bottom:1px solid #ddd}
td{text-align:right}td:first-child,th:first-child{text-align:left}.bad{color:#a00;font-weight:bold}
pre{background:#f5f5f5;padding:.6em;overflow-x:auto;font-size:13px}img{max-width:100%}"""
HEAD = ["asked", "answered", "faulty", "gap error, median", "largest", "time, median"]


def table(head, rows):
    cells = lambda row, tag: "".join(f"<{tag}>{value}</{tag}>" for value in row)
    body = "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows)
    return f"<table><tr>{cells(head, 'th')}</tr>{body}</table>"


def row(name, tally):
    faulty = tally["faulty"]
    return [html.escape(name), tally["asked"], tally["answered"],
            f'<span class="bad">{faulty}</span>' if faulty else 0,
            f'{tally["gap_error_median"]:.1e}', f'{tally["gap_error_largest"]:.1e}',
            f'{1e6 * tally["seconds_median"]:.2f} us']


def asked(report):
    return [library for library in report["libraries"] if library["families"].get("all", {}).get("answered")]


def picture(report):
    figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    floor = 1e-17  # an error of 0 is drawn here
    for library in asked(report):
        points = [(1e6 * tally["seconds_median"], max(tally["gap_error_median"], floor))
                  for name, tally in library["families"].items() if name != "all" and tally["answered"]]
        axes.scatter(*zip(*points), s=22, label=library["name"], alpha=0.75)
    axes.set(xscale="log", yscale="log", xlabel="time of the moves and the question, us",
             ylabel="error of the gap, share of the larger diameter",
             title="Median error against median time; a dot is a family of pairs")
    axes.grid(alpha=0.3)
    axes.legend()
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=130)
    return '<img alt="error against time" src="data:image/png;base64,%s">' % base64.b64encode(png.getvalue()).decode()


def kinds(report):
    libraries = asked(report)
    names = sorted({kind for library in libraries for kind in library["families"]["all"]["kinds"]})
    rows = [[html.escape(kind)] + [library["families"]["all"]["kinds"].get(kind, 0) for library in libraries]
            for kind in names]
    return table(["kind of fault"] + [html.escape(library["name"]) for library in libraries], rows)


def failures(report):
    text = ""
    for number, failure in enumerate(report["failures"], 1):
        what = html.escape(f'{failure["library"]}: {failure["kind"]} ({failure["family"]})')
        text += (f'<h3>{number}. {what}</h3><p>{html.escape(failure["text"])}</p>'
                 f'<p>failures.jsonl, line {number}; failure_{number}.cpp, failure_{number}.c</p>'
                 f'<pre>{html.escape(json.dumps(failure["pair"]))}</pre>')
    return text or "<p>None.</p>"


def page(report):
    parts = [f"<p>{report['questions']} questions, seed {report['seed']}, {report['seconds']:.0f} s. "
             "Each answer is judged in exact arithmetic; what a library does not offer is not asked. "
             "Errors are shares of the larger diameter.</p>",
             table(["library"] + HEAD, [row(library["name"], library["families"]["all"]) for library in asked(report)]),
             picture(report) if asked(report) else "", "<h2>Kinds of fault</h2>", kinds(report), "<h2>Families</h2>"]
    for library in asked(report):
        families = [row(name, tally) for name, tally in library["families"].items() if name != "all"]
        parts += [f"<h3>{html.escape(library['name'])} {html.escape(library['version'])}</h3>",
                  table(["family"] + HEAD, families)]
    parts += ["<h2>Failures, the first of each kind and family, made smaller</h2>", failures(report)]
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
