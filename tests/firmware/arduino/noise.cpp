// A port that never runs dry, of bytes that end no frame: ends with 0 once the sensors were read a hundred times.
#include "arduino/rig.h"

unsigned sensors_read = 0;
int pins[64];
uint32_t now = 0;

struct Noise {
  unsigned long taken = 0;
  void begin(long) {}
  int read() { return ++taken > 10000000 ? exit(1), 0 : 0x55; }
  void write(const uint8_t*, int) {}
};

using namespace tendril;

int main() {
  const Config config = {"noise", HOLDS_PRESSURE, 0, 300000, 340000, 20000, {84, 168, 328}};
  const Wiring<1> wiring = {{{0, 103, 51, 973, 618750}}, {{2, 3, true}}, 10, 11};
  Noise port;
  Rig<1, Noise> rig(config, wiring, port);
  rig.begin();
  while (sensors_read < 100) rig.poll();
  return 0;
}
