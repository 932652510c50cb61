// Hostile bytes on stdin, to a board that is driving: it must count each frame that is none and move nothing.
//   tendril-fuzz < BYTES
// Prints "rejected R moved M": M counts bytes after which an output had changed.
#include <cstdio>

#include "config.h"

namespace {

using namespace tendril;

constexpr int32_t TARGET = 100000;
const int32_t PRESSURES[HOST_CHANNELS] = {TARGET, TARGET, TARGET, TARGET, TARGET, TARGET, TARGET, TARGET};

struct Seen {
  int64_t words[2 * HOST_CHANNELS + 2];
  bool operator!=(const Seen& other) const {
    for (unsigned i = 0; i < sizeof words / sizeof *words; ++i) {
      if (words[i] != other.words[i]) return true;
    }
    return false;
  }
};

Seen outputs_of(const HostBoard& board) {
  Seen seen{};
  for (uint8_t i = 0; i < HOST_CHANNELS; ++i) {
    seen.words[2 * i] = board.opening(i);
    seen.words[2 * i + 1] = board.setpoint(i);
  }
  seen.words[2 * HOST_CHANNELS] = board.outputs().vent | board.outputs().cut << 1 | board.outputs().raw << 2;
  seen.words[2 * HOST_CHANNELS + 1] = board.reasons();
  return seen;
}

void command(HostBoard& board, uint16_t sequence, uint8_t wanted, uint32_t now) {
  uint8_t frame[command_size(HOST_CHANNELS)], wire[on_wire(command_size(HOST_CHANNELS))];
  Writer w(frame);
  w.u8(PROTOCOL);
  w.u8(COMMAND);
  w.u16(sequence);
  w.u32(now);
  w.u8(wanted);
  w.u8(HOST_CHANNELS);
  w.u16(wanted & VENT ? 0 : 0xFF);
  for (uint8_t i = 0; i < HOST_CHANNELS; ++i) w.i32(wanted & VENT ? 0 : TARGET);
  const uint8_t size = seal(frame, w.size(), wire);
  for (uint8_t i = 0; i < size; ++i) board.receive(wire[i], now);
}

}  // namespace

int main() {
  HostBoard board(HOST_CONFIG, 1, 0);
  uint32_t now = 0;
  uint16_t sequence = 1000;
  command(board, sequence++, VENT, now);
  for (int i = 0; i < 50; ++i) {
    now += 1000;
    command(board, sequence++, 0, now);
    board.step(now, PRESSURES, false);
  }
  const Seen driving = outputs_of(board);
  if (board.outputs().vent) return 1;
  unsigned long moved = 0, fed = 0;
  for (int byte = std::getchar(); byte != EOF; byte = std::getchar()) {
    board.receive(static_cast<uint8_t>(byte), now);
    if (outputs_of(board) != driving) ++moved;
    // Of time only so little that 12 MB of bytes do not wake the watchdog; a changed setpoint moves in it all the same.
    if (++fed % 128 == 0) board.step(++now, PRESSURES, false);
  }
  std::printf("rejected %lu moved %lu\n", static_cast<unsigned long>(board.rejected()), moved);
  return 0;
}
