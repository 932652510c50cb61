// A Teensy whose loop hangs with open valves: its timer vents and starts it again; while it turns, nothing does.
#include "wired.h"

uint32_t CCM_CCGR3, SCB_AIRCR;
uint16_t WDOG1_WCR, WDOG1_WMCR = 1;
Service WDOG1_WSR;
void (*interrupt)();

struct Silence {
  void begin(long) {}
  int read() { return -1; }
  void write(const uint8_t*, int) {}
};

int main() {
  Silence port;
  tendril::Rig<1, Silence> rig(CONFIG, WIRING, port);
  rig.begin();
  if (CCM_CCGR3 != 3u << 16 || WDOG1_WMCR != 0 || WDOG1_WCR != 0x34) return 1;
  const uint32_t begin = now;
  while (now - begin < 1000000) {
    rig.poll();
    interrupt();
  }
  if (SCB_AIRCR != 0 || WDOG1_WSR.count < 900) return 2;
  pins[2] = 200, pins[3] = 200, pins[10] = HIGH;
  now += 100000;
  interrupt();
  if (SCB_AIRCR != 0 || pins[2] != 200) return 3;
  now += 30000;
  interrupt();
  return pins[2] == 0 && pins[3] == 0 && pins[10] == LOW && SCB_AIRCR == 0x05FA0004 ? 0 : 4;
}
