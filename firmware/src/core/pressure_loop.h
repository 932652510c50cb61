// From pressure error to valve opening, in integers: one call a millisecond.
#pragma once
#include "frames.h"

namespace tendril {

// Gains in openings (1/32767) per Pa, times 256; the reset time as 65536 ms over it.
struct Gains {
  int32_t inflate;   // while below the setpoint; 84 is 1e-5 per Pa
  int32_t exhaust;   // while above it; 168 is 2e-5 per Pa
  int32_t integral;  // 328 is 0.2 s
};

class PressureLoop {
 public:
  void reset() { integral_ = 0; }

  // Opening after another millisecond with `error` [Pa], setpoint minus pressure.
  int16_t step(int32_t error, const Gains& gains) {
    const int32_t within = clamp(error, ERROR_END);
    const int32_t proportional = clamp(within * (within > 0 ? gains.inflate : gains.exhaust), OPENING_END * 256);
    const int32_t opening = (proportional + integral_) / 256;
    // The integral waits while the valve is at its end and the error asks for more.
    if ((opening < OPENING_END || error < 0) && (opening > -OPENING_END || error > 0)) {
      integral_ = clamp(integral_ + proportional / 256 * gains.integral / 256, OPENING_END * 256);
    }
    return static_cast<int16_t>(clamp(opening, OPENING_END));
  }

 private:
  static constexpr int32_t ERROR_END = 200000;  // [Pa] times a gain of 10000 still fits
  static int32_t clamp(int32_t value, int32_t end) { return value > end ? end : value < -end ? -end : value; }
  int32_t integral_ = 0;  // openings times 256
};

}  // namespace tendril
