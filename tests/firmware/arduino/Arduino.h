// As much of Arduino as the library calls, for this machine.
#pragma once
#include <stdint.h>
#include <stdlib.h>

enum { LOW, HIGH, INPUT_PULLUP, OUTPUT };

extern unsigned sensors_read;

inline void pinMode(int, int) {}
inline void digitalWrite(int, int) {}
inline int digitalRead(int) { return LOW; }
inline void analogWrite(int, int) {}
inline int analogRead(int) { return ++sensors_read, 103; }
inline uint32_t micros() {
  static uint32_t now = 0;
  return now += 10;
}
