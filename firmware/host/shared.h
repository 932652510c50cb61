// What the host build shares with a simulated plant: a file of 8-byte little endian words, each written by one side only.
// A word is read and written whole; nothing needs more than one of them to agree.
#pragma once
#include <atomic>
#include <cstdint>

namespace tendril {

using Word = std::atomic<int64_t>;
static_assert(sizeof(Word) == 8 && ATOMIC_LLONG_LOCK_FREE == 2, "words are shared with another process");

constexpr int64_t SHARED_MAGIC = 0x314C52444E54;  // "TNDRL1"

struct Shared {
  Word magic;              // by the plant, before the firmware starts
  Word pressures[16];      // by the plant: gauge [Pa]; INT64_MIN is a broken sensor
  Word e_stop;             // by the plant: 1 while the hardware stop is pressed
  Word steps;              // by the firmware, all below: rises once a millisecond while it runs
  Word setpoints[16];      // [Pa] slewed and limited
  Word openings[16];       // 1/32767, negative exhausts
  Word flags;              // Output bits of core/frames.h
  Word reasons;            // Reason bits
  Word last_command;       // the board's clock at the newest valid command [us]
  Word vented;             // the board's clock when it last began to vent [us]
  Word rejected;           // frames refused since boot
  Word boot;               // the board's count of boots
  Word hold_back;          // by the plant: each answer leaves so much after it was made [us], as from a slow adapter
};
static_assert(sizeof(Shared) == 58 * 8, "controller/virtual/board.py reads 58 words");

}  // namespace tendril
