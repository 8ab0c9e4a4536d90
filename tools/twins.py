"""Write the JupyterLab twin of every lesson into lessons/jupyter/.

python tools/twins.py            # write
python tools/twins.py --check    # only say which twins differ from their lessons
"""

import sys
from pathlib import Path

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.jupyter.notebooks import as_text, twin, twin_name

FOLDER = Path(__file__).resolve().parent.parent / "lessons" / "jupyter"


def main():
    wanted = {FOLDER / twin_name(lesson): as_text(twin(lesson)) for lesson in LESSONS}
    stale = [path for path, text in wanted.items() if not path.exists() or path.read_text("utf-8") != text]
    left_over = sorted(set(FOLDER.glob("*.ipynb")) - set(wanted))
    if "--check" in sys.argv[1:]:
        sys.exit(f"not as the lessons are: {', '.join(path.name for path in stale + left_over)}" if stale or left_over else 0)
    FOLDER.mkdir(exist_ok=True)
    for path in stale:
        path.write_text(wanted[path], "utf-8")
    for path in left_over:
        path.unlink()
    print(f"{len(wanted)} notebooks, {len(stale)} written, {len(left_over)} removed")


if __name__ == "__main__":
    main()
