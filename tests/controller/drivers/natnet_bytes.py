"""One frame and one set of model definitions for each NatNet version, byte by byte as the layout has them.

Written by hand, so that they depend on neither our parser nor our emulator.
"""

ZERO, HALF, QUARTER, EIGHTH, SIXTEENTH = "00000000", "0000003f", "0000803e", "0000003e", "0000803d"
ONE, TWO, MINUS_HALF = "0000803f", "00000040", "000000bf"
UPRIGHT = ZERO + ZERO + ZERO + ONE

RODS = "726f647300" + "02000000" + (HALF + QUARTER + ZERO) + (ZERO + ZERO + ZERO)  # "rods": one seen, one not
ALL = "616c6c00" + "00000000"  # "all", empty
OTHER = ONE + HALF + EIGHTH
BODY_2 = "02000000" + (HALF + QUARTER + ONE) + UPRIGHT + SIXTEENTH + "0100"  # tracked
BODY_3_LOST = "03000000" + (ZERO + ZERO + ZERO) + UPRIGHT + ZERO + "0000"
MARKER_OF_2 = "01000200" + (MINUS_HALF + QUARTER + EIGHTH) + SIXTEENTH + "0a00" + ZERO  # first of body 2
MARKER_OF_RODS = "2a000000" + (HALF + QUARTER + ZERO) + SIXTEENTH + "0200" + ZERO  # 42, found by its place
OCCLUDED_OF_2 = "02000200" + (ONE + ONE + ONE) + SIXTEENTH + "0900" + ZERO
FILLED_OF_2 = "03000200" + (TWO + ONE + HALF) + SIXTEENTH + "0c00" + ZERO
UNLABELLED = "57c30000" + (ONE + TWO + HALF) + SIXTEENTH + "1200" + ZERO  # 50007
SKELETON = "07000000" + "01000000" + BODY_2
PLATE = "01000000" + "01000000" + "02000000" + ONE + TWO  # a channel of two values
DEVICE = "02000000" + "01000000" + "01000000" + HALF
ASSET = "09000000" + "01000000" + BODY_2 + "01000000" + MARKER_OF_2
TIMES = (
    "00000000" + "00000000" + "0000000000002940"  # time code, 12.5 s
    "0504030201000000" + "0604030201000000" + "0704030201000000"  # exposure, arrival, departure
)
END = "00000000"


def _old(*sections: tuple[int, str]) -> str:
    return "".join(count.to_bytes(4, "little").hex() + content for count, content in sections)


def _sized(*sections: tuple[int, str]) -> str:
    return "".join(
        count.to_bytes(4, "little").hex() + (len(content) // 2).to_bytes(4, "little").hex() + content
        for count, content in sections
    )


NONE = (0, "")
FRAMES = {
    (3, 0): "e8030000"  # 1000
    + _old((2, RODS + ALL), (1, OTHER), (1, BODY_2), NONE, (3, MARKER_OF_2 + MARKER_OF_RODS + UNLABELLED), NONE, NONE)
    + TIMES
    + "0200"  # models changed
    + END,
    (3, 1): "e9030000"
    + _old((1, RODS), NONE, (1, BODY_2), (1, SKELETON), (2, OCCLUDED_OF_2 + MARKER_OF_2), (1, PLATE), (1, DEVICE))
    + TIMES
    + "0000",
    (4, 0): "ea030000"
    + _old(NONE, NONE, (2, BODY_2 + BODY_3_LOST), NONE, (2, FILLED_OF_2 + UNLABELLED), NONE, NONE)
    + TIMES
    + "0000"
    + END,
    (4, 1): "eb030000"
    + _sized(
        (2, RODS + ALL), (1, OTHER), (1, BODY_2), NONE, (1, ASSET), (2, MARKER_OF_2 + UNLABELLED), NONE, (1, DEVICE)
    )
    + TIMES
    + "0000000000000000"  # no grandmaster clock
    + "0000"
    + END,
}
"""Payloads in hex."""

RODS_SET = "726f647300" + "02000000" + "74697000" + "6d696400"  # "rods": "tip", "mid"
PLATFORM = "706c6174666f726d00" + "02000000" + "ffffffff" + ZERO * 3  # "platform", 2, no parent, offset
THREE = "03000000" + ZERO * 9 + "00000000" * 3
DEFINITIONS = {
    (3, 0): "02000000" + ("00000000" + RODS_SET) + ("01000000" + PLATFORM + THREE),
    (3, 1): "02000000" + ("00000000" + RODS_SET) + ("01000000" + PLATFORM + THREE),
    (4, 0): "03000000"
    + ("00000000" + RODS_SET)
    + ("01000000" + PLATFORM + THREE + "61006200" + "6300")  # markers "a", "b", "c"
    + ("05000000" + "43616d00" + ZERO * 7),  # camera "Cam"
    (4, 1): "03000000"
    + ("05000000" + "20000000" + "43616d00" + ZERO * 7)
    + ("00000000" + "11000000" + RODS_SET)
    + ("01000000" + "57000000" + PLATFORM + THREE + "61006200" + "6300"),
}
SERVER = (
    "4d6f74697665" + "00" * 250  # "Motive"
    + "03010000" + "04010000"  # Motive 3.1, NatNet 4.1
    + "8096980000000000"  # 10 MHz
    + "e705" + "01" + "efff2a63"  # 1511, multicast to 239.255.42.99
)  # fmt: skip
