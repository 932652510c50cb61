// The frames of docs/serial.md, little endian: where each number lies, and nothing else.
#pragma once
#include <stdint.h>
#include <string.h>

#include "cobs.h"
#include "crc16.h"

namespace tendril {

constexpr uint8_t PROTOCOL = 1;
constexpr uint16_t FIRMWARE = 0x0100;  // major << 8 | minor
constexpr uint8_t CHANNELS_MAX = 16;

enum Type : uint8_t { HELLO = 0x01, COMMAND = 0x02, HELLO_REPLY = 0x81, STATE = 0x82 };
enum Wanted : uint8_t { VENT = 1, CUT = 2, RAW = 4, WANTED_ALL = 7 };
enum Reason : uint8_t { BOOT = 1, GREETED = 2, WATCHDOG = 4, OVER_PRESSURE = 8, E_STOP_INPUT = 16, BROKEN_SENSOR = 32 };
enum Output : uint8_t { VENTED = 1, SUPPLY_CUT = 2, TAKES_RAW = 4, LIMITED = 8 };
enum Capability : uint8_t { HOLDS_PRESSURE = 1, TAKES_OPENINGS = 2, CUTS_SUPPLY = 4, HAS_E_STOP_INPUT = 8 };

constexpr int32_t SETPOINT_END = 1200000;  // [Pa] beyond it a setpoint is nonsense on any board
constexpr int32_t OPENING_END = 32767;     // fully open
constexpr int32_t BROKEN = INT32_MIN;      // instead of a pressure

constexpr uint8_t CRC_SIZE = 2;
constexpr uint8_t NAME_SIZE = 16;
constexpr uint8_t HELLO_SIZE = 8 + CRC_SIZE;
constexpr uint8_t HELLO_REPLY_SIZE = 48 + CRC_SIZE;
constexpr uint8_t command_size(uint8_t channels) { return static_cast<uint8_t>(12 + 4 * channels + CRC_SIZE); }
constexpr uint8_t state_size(uint8_t channels) { return static_cast<uint8_t>(24 + 4 * channels + CRC_SIZE); }
constexpr uint8_t on_wire(uint8_t size) { return static_cast<uint8_t>(size + 3); }  // 00, code, 00

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they lie");

template <typename Number>
Number number_at(const uint8_t* p) {
  Number value;
  memcpy(&value, p, sizeof value);
  return value;
}

inline uint16_t u16_at(const uint8_t* p) { return number_at<uint16_t>(p); }
inline uint32_t u32_at(const uint8_t* p) { return number_at<uint32_t>(p); }
inline int32_t i32_at(const uint8_t* p) { return number_at<int32_t>(p); }

// Writes one number after the other.
class Writer {
 public:
  explicit Writer(uint8_t* at) : first_(at), at_(at) {}
  void u8(uint8_t value) { *at_++ = value; }
  void u16(uint16_t value) { put(value); }
  void u32(uint32_t value) { put(value); }
  void i32(int32_t value) { put(value); }
  void text(const char* text, uint8_t size) {
    for (uint8_t i = 0; i < size; ++i) u8(static_cast<uint8_t>(*text ? *text++ : 0));
  }
  uint8_t size() const { return static_cast<uint8_t>(at_ - first_); }

 private:
  template <typename Number>
  void put(Number value) {
    memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }
  uint8_t* first_;
  uint8_t* at_;
};

// Adds the checksum to `size` bytes and stuffs them between two zeros into `out`; returns the bytes on the wire.
inline uint8_t seal(uint8_t* frame, uint8_t size, uint8_t* out) {
  const uint16_t crc = crc16(frame, size);
  frame[size] = static_cast<uint8_t>(crc);
  frame[size + 1] = static_cast<uint8_t>(crc >> 8);
  out[0] = 0;
  const uint8_t stuffed = cobs_encode(frame, static_cast<uint8_t>(size + CRC_SIZE), out + 1);
  out[stuffed + 1] = 0;
  return static_cast<uint8_t>(stuffed + 2);
}

}  // namespace tendril
