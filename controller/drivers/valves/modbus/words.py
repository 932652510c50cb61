"""Numbers as a device's registers hold them: one word or two, integers or floats, in its order of words and bytes."""

import struct
from typing import Literal, NamedTuple

Kind = Literal["int16", "int32", "float32"]
FLOAT_MAX = 3.4e38


class Coding(NamedTuple):
    """How a number lies in one or two registers; each is 16 bits, high byte first unless `swapped_bytes`."""

    kind: Kind
    signed: bool
    low_word_first: bool
    swapped_bytes: bool

    @property
    def width(self) -> int:
        """Registers of a number."""
        return 1 if self.kind == "int16" else 2

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest number."""
        if self.kind == "float32":
            return -FLOAT_MAX, FLOAT_MAX
        bits = 16 * self.width
        return (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if self.signed else (0, 2**bits - 1)

    def words(self, value: float) -> list[int]:
        """Registers of `value`, the nearest that there is; it is finite."""
        least, most = self.range
        held = min(max(value, least), most)
        data = struct.pack(self._format, held if self.kind == "float32" else round(held))
        return self._ordered(list(struct.unpack(f">{self.width}H", data)))

    def value(self, words: list[int]) -> float:
        """The number that `words` hold; a float may be nan."""
        data = struct.pack(f">{self.width}H", *self._ordered(words))
        return float(struct.unpack(self._format, data)[0])

    @property
    def _format(self) -> str:
        letter = {"int16": "h", "int32": "i", "float32": "f"}[self.kind]
        return ">" + (letter if self.signed or self.kind == "float32" else letter.upper())

    def _ordered(self, words: list[int]) -> list[int]:
        """From the device's order to ours, or back."""
        ordered = words[::-1] if self.low_word_first else words
        return [word >> 8 | (word & 0xFF) << 8 for word in ordered] if self.swapped_bytes else ordered
