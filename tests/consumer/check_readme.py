"""The C++ that the README shows is the C++ that the consumer tests compile and run."""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
shown = re.findall(r"```cpp\n(.*?)```", (source / "README.md").read_text(encoding="utf-8"), re.S)
tested = [(source / "tests/consumer/project" / name).read_text(encoding="utf-8")
          for name in ("contacts.cpp", "scene.cpp")]
if shown != tested:
    sys.exit(f"README.md shows {len(shown)} pieces of C++; they differ from contacts.cpp, scene.cpp")
print("README.md shows what is tested")
