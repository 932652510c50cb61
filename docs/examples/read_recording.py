"""A recording in numpy: how far the tip was from its reference.

    tendril recordings export ID --format rrd --out run.rrd
    python read_recording.py run.rrd

Runs where Tendril is installed. Elsewhere read what `tendril recordings export` writes: CSV, Parquet, MATLAB or MCAP.
"""

import argparse
from pathlib import Path

import numpy as np

from recordings.read.reader import read_rows


def main() -> None:
    """Read three fields of every recorded tick, and print the figures of the tip's error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help="a recording (.rrd)")
    rows = read_rows(parser.parse_args().file, ("p_meas", "p_ref", "mode"))
    t = 1e-9 * (rows["t_ns"] - rows["t_ns"][0])
    error = np.linalg.norm(rows["p_ref"] - rows["p_meas"], axis=1)
    print(f"{len(t)} ticks, {t[-1]:.3f} s, modes {np.unique(rows['mode']).tolist()}")
    print(f"error: rms {1e3 * np.sqrt(np.nanmean(error**2)):.2f} mm, largest {1e3 * np.nanmax(error):.2f} mm")


if __name__ == "__main__":
    main()
