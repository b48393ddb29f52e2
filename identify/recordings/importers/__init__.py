"""Recordings from files of other tools: one module per format, and one entry in `IMPORTERS`."""

import inspect
import zlib
from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...errors import NotAFile, RecordingError, UnknownKey
from ...file_names import looked_in

if TYPE_CHECKING:  # a process that reads a file imports this package, but needs none of these
    from ...model import Model
    from ..recording import Recording
    from ..tables.table import Table


BEGINNING = 16_384
"""Size of the beginning of a file that is searched for marks [B]: RSI telegrams have 4000, behind text."""
GZIP = b"\x1f\x8b"


class Entry(NamedTuple):
    """A format and its importer."""

    # "module:function", relative to this package, imported on demand: `(source) -> list[Table]` for a table,
    # else `(source, model, **options) -> list[Recording]`.
    place: str
    content: str  # name of the format, and what a file has to contain
    endings: tuple[str, ...] = ()  # endings of the names of such files
    inside: tuple[str, ...] = ()  # patterns of a file in such a folder
    marks: tuple[bytes, ...] = ()  # bytes at the beginning of such files, whatever their name
    table: bool = False  # whether it is read as a table, whose columns `import_table` turns into signals
    robot: bool = False  # whether such files contain their robot; otherwise it has to be given
    # Library in native code that reads such tables. As a damaged file may crash it, it runs in a separate
    # process. Empty if no such library is used.
    library: str = ""

    @property
    def name(self) -> str:
        """Name of the format."""
        return self.content.partition(":")[0]


BAG = "ros2_bag"
"""Kind of bags, whose content shows whether they are read as tables."""

IMPORTERS: dict[str, Entry] = {
    "csv": Entry(
        ".tables.table:read_csv",
        "CSV: a line of names, a row a sample; UR's RTDE and libfranka too",
        (".csv", ".csv.gz", ".tsv", ".txt", ".txt.gz"),
        table=True,
    ),
    "matlab": Entry(
        "array_files:read_matlab",
        "MATLAB: arrays, structures too; version 7.3 needs the extra hdf5",
        (".mat",),
        table=True,
        library="scipy.io.loadmat or h5py",
    ),
    "hdf5": Entry(
        "array_files:read_hdf5",
        "HDF5: data sets, in groups too; needs the extra hdf5",
        (".h5", ".hdf5", ".hdf"),
        table=True,
        library="h5py",
    ),
    "parquet": Entry(
        "array_files:read_parquet",
        "Parquet: columns of numbers or lists; needs the extra parquet",
        (".parquet", ".pq"),
        table=True,
        library="pyarrow",
    ),
    "lerobot": Entry(
        "array_files:read_lerobot",
        "LeRobot data set: a run an episode; needs the extra parquet",
        inside=("meta/info.json",),
        table=True,
        library="pyarrow",
    ),
    "npz": Entry("array_files:read_npz", "NumPy: named arrays", (".npz",), table=True),
    "npy": Entry("array_files:read_npy", "NumPy array: a row a sample, named or not", (".npy",), table=True),
    "json": Entry(
        ".tables.rows:read_json_lines",
        "JSON lines: an object a sample",
        (".jsonl", ".ndjson", ".jsonl.gz", ".ndjson.gz"),
        table=True,
    ),
    BAG: Entry(
        ".bags.ros2_bag:import_ros2_bag",
        "ROS bag: joint states or fields of other messages, ROS 1 and MCAP too; needs the extra ros2",
        (".db3", ".bag", ".bag.active"),
        ("metadata.yaml", "*.db3"),
    ),
    "kuka_trace": Entry(
        "kuka_trace:import_kuka_trace",
        "KUKA trace: .dat beside .r64, all files of one name a run",
        (".dat", ".r64"),
        ("*.[dD][aA][tT]",),
    ),
    "rsi": Entry(
        "rsi_telegrams:import_rsi_telegrams",
        "KUKA RSI: telegrams <Rob ...> with AIPos and MACur, as text",
        marks=(b"<Rob", b"<IPOC>"),
    ),
    "exidyn": Entry(".mcap.mcap_file:import_recording", "exidyn: its own recordings", (".mcap",), robot=True),
}
"""Name -> format and importer. The content of an MCAP file shows whether exidyn or another tool wrote it."""


def import_source(
    source: Path | str, model: "Model | None" = None, kind: str | None = None, **options: Any
) -> list["Recording"]:
    """Import a file or folder of any known format.

    Args:
        source: Path of the file or folder.
        model: Nominal model; exidyn's own files contain theirs.
        kind: Key of `IMPORTERS`; by default the format is detected.
        options: Options of the importer; its docstring lists them, that of `import_table` for tables.

    Raises:
        NotAFile: The path does not exist, or no importer can read it.
        RecordingError: Files of this format do not contain their robot, and there is no model.
        UnknownKey: An option or kind does not exist; the message lists the valid ones.
        MissingPackage: A library that the format needs is not installed.
    """
    source = Path(source)
    kind, function = _reader(source, kind)
    if IMPORTERS[kind].table:
        from ..tables.import_table import import_table

        function = partial(import_table, cache(function))
    valid = tuple(inspect.signature(function).parameters)[2:]
    for option in options:
        if option not in valid:
            raise UnknownKey(option, f"import of {kind}", valid)
    if model is None and not IMPORTERS[kind].robot:
        raise RecordingError(
            f"{source}: {IMPORTERS[kind].name} does not name its robot; give the robot too (--robot FILE)"
        )
    from ..hints import import_with_hints

    return import_with_hints(function, source, model, options)


def read_tables(source: Path | str, kind: str | None = None) -> list["Table"]:
    """Tables of a file, one per run, before the meaning and units of their columns are known."""
    source = Path(source)
    kind, function = _reader(source, kind)
    if kind == BAG and (tables := _fields_of_bag(source)):
        return tables
    if not IMPORTERS[kind].table:
        raise RecordingError(f"{source}: {IMPORTERS[kind].name} is not a table")
    return function(source)


def is_table(source: Path) -> bool:
    """Whether a file or folder has named columns, as bags of other messages than joint states do."""
    kind = kind_of(source)
    return IMPORTERS[kind].table or (kind == BAG and bool(_fields_of_bag(source)))


def _fields_of_bag(source: Path) -> list["Table"]:
    """Fields of the messages of a bag by topic; empty if it has joint states."""
    tables: list[Table] = import_module("..bags.bag_reader", __name__).read_bag(source).tables
    return tables


def _reader(source: Path, kind: str | None) -> tuple[str, Callable[..., Any]]:
    """Format of a file or folder, and the function that reads it."""
    if not source.exists():
        raise NotAFile(f"{source} does not exist{looked_in(source)}")
    kind = kind or kind_of(source)
    if kind not in IMPORTERS:
        raise UnknownKey(kind, "import: kind of source", tuple(IMPORTERS))
    entry = IMPORTERS[kind]
    return kind, partial(_tables, kind) if entry.table else _function(entry.place)


def _function(place: str) -> Callable[..., Any]:
    """Function of an entry's place."""
    module, name = place.split(":")
    function: Callable[..., Any] = getattr(import_module(f".{module}", __name__), name)
    return function


def _tables(kind: str, source: Path) -> list["Table"]:
    """Tables of a file with one row per sample, read in a separate process if a library reads it."""
    from ..reading_limits import call_reader
    from ..tables.rows import by_sample
    from ..tables.table import Table

    place, library = IMPORTERS[kind].place, IMPORTERS[kind].library
    if not library:
        return [by_sample(table) for table in _function(place)(source)]
    rows = call_reader(f"{__name__}:read_rows", library, source, place)
    return [by_sample(Table(**row | {"joints": tuple(row["joints"])})) for row in rows]


def read_rows(source: str, place: str) -> list[dict[str, Any]]:
    """Fields of the tables in a file, without lines of text; this runs in the separate process."""
    tables: list[Table] = _function(place)(Path(source))
    return [{key: value for key, value in table._asdict().items() if key != "lines"} for table in tables]


def kind_of(source: Path) -> str:
    """Key in `IMPORTERS` of the format of a file or folder; an error names its folders that have one."""
    kind = _kind(source)
    if kind is None and source.name.endswith(".mcap.part"):
        raise NotAFile(
            f"{source} is unfinished: its recorder crashed or still writes. Repair it: "
            f"exidyn info --repair {source}"
        )
    if kind is None:
        below = source.iterdir() if source.is_dir() else ()
        folders = sorted(path.name for path in below if path.is_dir() and _kind(path))
        inside = f", but these folders in it can, one at a time: {', '.join(folders)}" if folders else ""
        known = [
            f"{entry.name} ({(*entry.endings, *entry.inside, 'by its content')[0]})"
            for entry in IMPORTERS.values()
        ]
        raise NotAFile(f"{source} cannot be imported{inside}. Known formats: {', '.join(known)}")
    return kind


def _beginning(source: Path) -> bytes:
    """First bytes of a file, decompressed; empty for a damaged file, which its reader reports."""
    try:
        with open(source, "rb") as file:
            begin = file.read(BEGINNING)
        packed = begin.startswith(GZIP)
        return zlib.decompressobj(zlib.MAX_WBITS | 16).decompress(begin, BEGINNING) if packed else begin
    except (OSError, zlib.error):
        return b""


def _kind(source: Path) -> str | None:
    name = source.name.lower()
    begin = _beginning(source) if source.is_file() else b""
    if name.endswith(".mcap") and source.is_file():
        # A file that is not MCAP counts as our own, so that our reader reports what is wrong. The first
        # metadata record of our files begins within 256 bytes, behind the header of the format.
        own_recording = not begin.startswith(b"\x89MCAP0\r\n") or b"\x06\x00\x00\x00exidyn" in begin[:256]
        return "exidyn" if own_recording else BAG
    for kind, entry in IMPORTERS.items():
        if entry.marks and all(mark in begin for mark in entry.marks):
            return kind
    for kind, entry in IMPORTERS.items():
        if source.is_dir():
            matches = any(any(source.glob(pattern)) for pattern in entry.inside)
        else:
            matches = name.endswith(entry.endings)
        if matches:
            return kind
    # A folder of MCAP files without metadata is a bag, unless they are exidyn's recordings.
    files = sorted(source.glob("*.mcap")) if source.is_dir() else []
    return BAG if files and _kind(files[0]) == BAG else None
