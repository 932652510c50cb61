// Consistent overhead byte stuffing: a frame without zeros, so that a zero can only be an end (Cheshire and Baker, 1999).
#pragma once
#include <stdint.h>

namespace tendril {

// Writes `size` <= 253 bytes stuffed to `out` (size + 1 bytes); returns how many.
inline uint8_t cobs_encode(const uint8_t* bytes, uint8_t size, uint8_t* out) {
  uint8_t code_at = 0, at = 1, code = 1;
  for (uint8_t i = 0; i < size; ++i) {
    if (bytes[i] != 0) {
      out[at++] = bytes[i];
      ++code;
    } else {
      out[code_at] = code;
      code_at = at++;
      code = 1;
    }
  }
  out[code_at] = code;
  return at;
}

// Unstuffs in place; returns the bytes left, 0 where it is no stuffed frame. What is shorter than 254 has no code 0xFF.
inline uint8_t cobs_decode(uint8_t* bytes, uint8_t size) {
  uint8_t from = 0, to = 0;
  while (from < size) {
    const uint8_t code = bytes[from++];
    if (code == 0 || code == 0xFF || code - 1 > size - from) return 0;
    for (uint8_t i = 1; i < code; ++i) bytes[to++] = bytes[from++];
    if (from < size) bytes[to++] = 0;
  }
  return to;
}

}  // namespace tendril
