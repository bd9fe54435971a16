"""Parquet: a file a shard, a row a frame; what pandas, Polars, DuckDB, Spark and ray.data read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...errors import CamrigError
from .export import make_new
from .shard_file import PARTS, Sample, samples
from .store import Store

#: A row group is what a reader takes at once.
_ROWS_A_GROUP = 256


def write_parquet(store: Store, to: Path) -> int:
    """Writes TO/SHARD.parquet of each shard; returns how many rows. Columns: key, shard, camera, frame, time_ns, seed, image (JPEG or PNG), truth (JSON),
    and the further files of a frame by their extension with _ for a dot, null where it has none."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise CamrigError("unavailable", "--format parquet needs pyarrow: pip install 'camrig[farm]'") from None
    manifest = list(store.manifest())
    make_new(to)
    schema = pyarrow.schema([
        ("key", pyarrow.string()), ("shard", pyarrow.string()), ("camera", pyarrow.string()), ("frame", pyarrow.int64()), ("time_ns", pyarrow.int64()),
        ("seed", pyarrow.int64()), ("image", pyarrow.binary()), ("truth", pyarrow.string()), *((_column(part), pyarrow.binary()) for part in PARTS)])
    count = 0
    for told in manifest:
        rows: list[dict[str, Any]] = []
        with parquet.ParquetWriter(to / f"{told['shard']}.parquet", schema, compression="zstd") as writer:
            for sample in samples(store.shard_path(told["shard"]), told):
                rows.append(_row(told, sample))
                if len(rows) == _ROWS_A_GROUP:
                    writer.write_table(pyarrow.Table.from_pylist(rows, schema))
                    rows = []
                count += 1
            if rows:
                writer.write_table(pyarrow.Table.from_pylist(rows, schema))
    return count


def _row(told: dict[str, Any], sample: Sample) -> dict[str, Any]:
    truth = sample.parts["json"].decode()
    return {"key": sample.key, "shard": told["shard"], "camera": sample.camera, "frame": int(sample.frame), "time_ns": json.loads(truth)["time_ns"], "seed": told["seed"],
            "image": sample.parts[told["picture_suffix"].lstrip(".")], "truth": truth, **{_column(part): sample.parts.get(part) for part in PARTS}}


def _column(part: str) -> str:
    return part.replace(".", "_")
