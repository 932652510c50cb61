// As much of Arduino as the library calls, for this machine; with the registers of a Teensy 4 where it is built as one.
#pragma once
#include <stdint.h>
#include <stdlib.h>

enum { LOW, HIGH, INPUT_PULLUP, OUTPUT };

extern unsigned sensors_read;
extern int pins[64];
extern uint32_t now;

inline void pinMode(int, int) {}
inline void digitalWrite(int pin, int value) { pins[pin] = value; }
inline int digitalRead(int) { return LOW; }
inline void analogWrite(int pin, int value) { pins[pin] = value; }
inline int analogRead(int) { return ++sensors_read, 103; }
inline uint32_t micros() { return now += 10; }

#if defined(__IMXRT1062__)
extern uint32_t CCM_CCGR3, SCB_AIRCR;
extern uint16_t WDOG1_WCR, WDOG1_WMCR;
// Counts what keeps the chip's watchdog from its end: the two words in their order.
struct Service {
  uint16_t before = 0;
  unsigned count = 0;
  void operator=(uint16_t word) {
    if (before == 0x5555 && word == 0xAAAA) ++count;
    before = word;
  }
};
extern Service WDOG1_WSR;
constexpr uint32_t CCM_CCGR_ON = 3;
constexpr uint32_t CCM_CCGR3_WDOG1(uint32_t n) { return n << 16; }
constexpr uint16_t WDOG_WCR_SRS = 1 << 4, WDOG_WCR_WDA = 1 << 5, WDOG_WCR_WDE = 1 << 2;
constexpr uint16_t WDOG_WCR_WT(uint16_t n) { return static_cast<uint16_t>(n << 8); }
extern void (*interrupt)();
struct IntervalTimer {
  void priority(uint8_t) {}
  bool begin(void (*call)(), uint32_t) { return interrupt = call, true; }
};
#endif
