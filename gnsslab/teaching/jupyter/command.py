"""The course as notebooks: copied into a folder of the student's own, and opened in JupyterLab on this machine only."""

import importlib.util
import json
import logging
import secrets
import signal
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from gnsslab.data.locations import project_folder

FOLDER = "gnsslab-course"
STATE = ".gnsslab"  # in that folder: what was copied, and JupyterLab's layout of the last time
SETTINGS = Path(__file__).parent / "settings"  # overrides.json: no news, no search for updates or extensions, a theme that follows the system


class Copies(NamedTuple):
    """What became of the notebooks in the student's folder: names of files."""

    new: list[str]
    renewed: list[str]  # as they were copied, but of an earlier gnsslab
    kept: list[str]  # changed by the student, and left alone though the course has another


def serve_notebooks(host="127.0.0.1", port=8000, open_browser=True, say=print):
    """Copy the notebooks into ./gnsslab-course and open JupyterLab there until Ctrl-C; `say` tells where.

    Raises ValueError where JupyterLab is not installed, or where others than this machine's user would be served.
    """
    from gnsslab.teaching.server.network import LOOPBACK, free_socket

    if host not in LOOPBACK:
        raise ValueError(f"--jupyter is for this machine only, not for {host}: a notebook runs any program. To serve a class, leave --jupyter out")
    if importlib.util.find_spec("jupyterlab") is None:
        raise ValueError("JupyterLab is not installed: type `pip install jupyterlab ipywidgets`, or leave --jupyter out")
    folder = Path.cwd() / FOLDER
    is_first = not folder.exists()
    for line in words_of(copy_notebooks(folder)):
        say(line)
    with free_socket(host, port) as listener:
        found = listener.getsockname()[1]
    if found != port:
        say(f"port {port} is taken; using {found}")
    _run_jupyterlab(folder, found, open_browser, is_first, say)
    say("stopped")


def copy_notebooks(folder):
    """Copy the lessons' notebooks into a folder: new ones are added, untouched ones renewed, those that the student changed left alone."""
    folder = Path(folder)
    (folder / STATE).mkdir(parents=True, exist_ok=True)
    copied = _copied_before(folder)
    done = Copies([], [], [])
    for source in sorted((project_folder("lessons") / "jupyter").glob("*.ipynb")):
        kind = _copy(source, folder / source.name, copied)
        if kind:
            getattr(done, kind).append(source.name)
    (folder / STATE / "copied.json").write_text(json.dumps(copied, indent=1, sort_keys=True), "utf-8")
    return done


def words_of(copies):
    """Return one sentence for each kind of what was copied.

    >>> words_of(Copies(["00_a.ipynb", "01_b.ipynb"], [], []))
    ['new in gnsslab-course: 00_a.ipynb, 01_b.ipynb']
    """
    words = {
        "new": f"new in {FOLDER}: {{}}",
        "renewed": "replaced by this version's, as you had not changed them: {}",
        "kept": "yours, so left as they are: {} (to get the course's, rename yours and start again)",
    }
    return [words[kind].format(", ".join(names)) for kind, names in copies._asdict().items() if names]


def _copied_before(folder):
    """Return {name: sha256} of the notebooks as they were copied into the folder."""
    try:
        return dict(json.loads((folder / STATE / "copied.json").read_text("utf-8")))
    except (OSError, ValueError, TypeError):
        return {}  # then every notebook that differs counts as the student's


def _copy(source, target, copied):
    """Copy one notebook where nothing of the student's is lost; return the kind of `Copies`, "" where there is nothing to do."""
    content = source.read_bytes()
    present = target.read_bytes() if target.exists() else None
    if present is not None and (present == content or copied.get(source.name) == _digest(content)):
        return ""  # there already, perhaps with the student's work in it
    if present is not None and copied.get(source.name) != _digest(present):
        return "kept"
    target.write_bytes(content)
    copied[source.name] = _digest(content)
    return "new" if present is None else "renewed"


def _digest(content):
    return sha256(content).hexdigest()


def _run_jupyterlab(folder, port, open_browser, is_first, say):
    """Run JupyterLab in a folder until it is told to stop."""
    from jupyterlab.labapp import LabApp

    first = min((path.name for path in folder.glob("*.ipynb")), default="")
    page = f"/lab/tree/{first}" if is_first else "/lab"
    options = _options(folder, port, open_browser, page)
    logging.disable(logging.ERROR)  # a page that is closed while the server writes to it is logged as an error, with a traceback
    server = LabApp.initialize_server(argv=[f"--{name}={value}" for name, value in options.items()])
    say(f"the notebooks are at {server.connection_url.rstrip('/')}{page}?token={options['IdentityProvider.token']} (stop them with Ctrl-C)")
    signal.signal(signal.SIGINT, lambda *_: server.stop(from_signal=True))  # JupyterLab would ask whether Ctrl-C was meant
    server.start()


def _options(folder, port, open_browser, page):
    """Return JupyterLab's settings: this machine only, a token of its own, silent, and nothing asked of the network."""
    return {
        "ServerApp.ip": "127.0.0.1",
        "ServerApp.port": port,
        "ServerApp.root_dir": folder,
        "ServerApp.open_browser": open_browser,
        "ServerApp.allow_root": True,  # in a container; others cannot reach it
        "IdentityProvider.token": secrets.token_urlsafe(24),
        "LabApp.default_url": page,
        "LabApp.app_settings_dir": SETTINGS,
        "LabApp.workspaces_dir": folder / STATE,
        "LabApp.news_url": None,
        "LabApp.check_for_updates_class": "jupyterlab.NeverCheckForUpdate",
        "LabApp.extension_manager": "readonly",
        "MappingKernelManager.transport_encryption": "auto",  # or each kernel would warn that it has none
    }
