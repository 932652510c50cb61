// CRC-16/CCITT-FALSE: polynomial 0x1021, first 0xFFFF, nothing reflected; of "123456789" it is 0x29B1.
#pragma once
#include <stdint.h>
#if defined(__AVR__)
#include <util/crc16.h>
#endif

namespace tendril {

constexpr uint16_t CRC_FIRST = 0xFFFF;

// One more byte, without a table and its RAM; on AVR by the assembler of its C library.
inline uint16_t crc16(uint16_t crc, uint8_t byte) {
#if defined(__AVR__)
  return _crc_xmodem_update(crc, byte);
#else
  crc = static_cast<uint16_t>((crc >> 8) | (crc << 8));
  crc = static_cast<uint16_t>(crc ^ byte);
  crc = static_cast<uint16_t>(crc ^ ((crc & 0xFF) >> 4));
  crc = static_cast<uint16_t>(crc ^ (crc << 12));
  return static_cast<uint16_t>(crc ^ ((crc & 0xFF) << 5));
#endif
}

inline uint16_t crc16(const uint8_t* bytes, uint8_t size) {
  uint16_t crc = CRC_FIRST;
  for (uint8_t i = 0; i < size; ++i) crc = crc16(crc, bytes[i]);
  return crc;
}

}  // namespace tendril
