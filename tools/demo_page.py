"""out/index.html of the demo: the examples with their table, plots, pictures and views."""
import html

STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 1100px; margin: 0 auto; padding: 16px; }
img { max-width: 100%; height: auto; background: #fff; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px; }
th, td { border-bottom: 1px solid #8885; padding: 3px 7px; text-align: right; }
td { white-space: nowrap; }
th:nth-child(-n+2), td:nth-child(-n+2) { text-align: left; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 480px), 1fr)); gap: 16px; }
figure { margin: 0; }
figcaption { font-size: 13px; opacity: 0.8; }
a.view { display: inline-block; margin: 0 10px 10px 0; padding: 8px 12px; border: 1px solid #8888; border-radius: 6px; }
"""


def table(head, rows):
    cells = lambda row, tag: "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row)
    return (f"<div class=wide><table><thead><tr>{cells(head, 'th')}</tr></thead><tbody>"
            + "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows) + "</tbody></table></div>")


def figures(names):
    return "<div class=pictures>" + "".join(
        f'<figure><a href="{name}"><img src="{name}" alt="{html.escape(words)}" loading="lazy"></a>'
        f"<figcaption>{html.escape(words)}</figcaption></figure>" for name, words in names) + "</div>"


def write(out, head, rows, plots, pictures, views):
    """plots, pictures: [(file, words)]; views: [(file, words)] of pages of `quoin view`; all beside the page."""
    links = "".join(f'<a class=view href="{name}">{html.escape(words)}</a>' for name, words in views)
    (out / "index.html").write_text(f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,"><title>quoin: the paper's examples</title><style>{STYLE}</style></head><body>
<h1>quoin: the paper's examples</h1>
<p>Beyabanaki, Mikola, Biabanaki, Mohammadi 2009, examples 5.1 to 5.4, by the paper's two methods (penalty; augmented
Lagrangian) and by quoin's default, which uses no penalty.</p>
<h2>Look at them</h2><p>{links}</p>
<h2>Error against run time, and the paper's figures</h2>{figures(plots)}
<h2>Results</h2>
<p>Error: largest difference from the exact answer by its largest value, over all steps (5.3: free flight). Cuts: steps halved
since they did not converge. Seconds: in the solver, output left out.</p>{table(head, rows)}
<h2>Blocks at some times</h2>{figures(pictures)}
</body></html>
""", encoding="utf-8")
