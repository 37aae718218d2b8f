"""The Python that the README shows prints what it says there."""
import contextlib
import io
import os
import pathlib
import re
import sys

import quoin

text = (pathlib.Path(sys.argv[1]) / "README.md").read_text(encoding="utf-8")
shown = re.findall(r"```python\n(.*?)```\n\nprints\n\n```\n(.*?)```", text, re.S)
if len(shown) != text.count("```python") or not shown:
    sys.exit("README.md: a piece of Python without what it prints")
for code, expected in shown:
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(code, {})
    if said.getvalue() != expected:
        sys.exit(f"README.md says\n{expected}\nand its Python\n{said.getvalue()}")
os.chdir(sys.argv[1])
own = pathlib.Path("tools/python/README.md").read_text(encoding="utf-8")
for code in re.findall(r"```python\n(.*?)```", own, re.S):
    exec(code, {"quoin": quoin})
print("README.md's Python prints what it says")
