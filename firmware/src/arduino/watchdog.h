// A core that hangs must vent: it is started again, and a board that starts drives no pin, so every valve is at rest.
#pragma once
#include <Arduino.h>
#if defined(__AVR__)
#include <avr/wdt.h>
#endif

namespace tendril {

constexpr uint32_t HANGS_US = 120000;

#if defined(__AVR__)
// The chip's own. After it has reset the chip it goes on with 15 ms: so it is set before anything else is.
struct Watchdog {
  Watchdog() { wdt_enable(WDTO_120MS); }
  void begin(void (*)()) {}
  void alive() { wdt_reset(); }
};
#elif defined(__IMXRT1062__)
// Teensy 4. The chip's own, WDOG1, takes 0.5 s at least, so a timer's interrupt looks before it and starts the chip again;
// WDOG1 does it where interrupts are off, or a fault keeps the timer from its turn. i.MX RT1060 reference manual, WDOG.
class Watchdog {
 public:
  void begin(void (*vent)()) {
    venting() = vent;
    alive_at() = micros();
    CCM_CCGR3 |= CCM_CCGR3_WDOG1(CCM_CCGR_ON);
    WDOG1_WMCR = 0;  // else the power-down counter holds its pin low after 16 s
    WDOG1_WCR = WDOG_WCR_SRS | WDOG_WCR_WDA | WDOG_WCR_WT(0) | WDOG_WCR_WDE;
    timer_.priority(0);
    timer_.begin(look, 10000);
  }
  void alive() {
    alive_at() = micros();
    WDOG1_WSR = 0x5555;
    WDOG1_WSR = 0xAAAA;
  }

 private:
  static void look() {
    if (micros() - alive_at() <= HANGS_US) return;
    venting()();
    SCB_AIRCR = 0x05FA0004;  // system reset request
  }
  static volatile uint32_t& alive_at() {
    static volatile uint32_t at = 0;
    return at;
  }
  static void (*&venting())() {
    static void (*vent)() = nullptr;
    return vent;
  }

  IntervalTimer timer_;
};
#else
// A board that is unknown here has none.
struct Watchdog {
  void begin(void (*)()) {}
  void alive() {}
};
#endif

}  // namespace tendril
