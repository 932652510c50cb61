// A port that never runs dry, of bytes that end no frame: ends with 0 once the sensors were read a hundred times.
#include "wired.h"

struct Noise {
  unsigned long taken = 0;
  void begin(long) {}
  int read() { return ++taken > 10000000 ? exit(1), 0 : 0x55; }
  void write(const uint8_t*, int) {}
};

int main() {
  Noise port;
  tendril::Rig<1, Noise> rig(CONFIG, WIRING, port);
  rig.begin();
  while (sensors_read < 100) rig.poll();
  return 0;
}
