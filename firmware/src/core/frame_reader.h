// Cuts the stream at zeros: whatever came before, the next zero begins again.
#pragma once
#include "frames.h"

namespace tendril {

template <uint8_t LONGEST>  // bytes of the longest frame that is ever wanted, with its checksum
class FrameReader {
 public:
  // True where `byte` ended something; `size()` then says what it was.
  bool push(uint8_t byte) {
    if (byte != 0) {
      if (count_ < LONGEST + 1) buffer_[count_] = byte;
      if (count_ < LONGEST + 2) ++count_;  // one too many is remembered as too long
      return false;
    }
    if (count_ == 0) return false;
    size_ = count_ > LONGEST + 1 ? 0 : checked(cobs_decode(buffer_, count_));
    count_ = 0;
    return true;
  }
  // Of the frame without its checksum; 0: it was none.
  uint8_t size() const { return size_; }
  const uint8_t* frame() const { return buffer_; }

 private:
  uint8_t checked(uint8_t size) const {
    if (size <= CRC_SIZE) return 0;
    const uint8_t body = static_cast<uint8_t>(size - CRC_SIZE);
    return crc16(buffer_, body) == u16_at(buffer_ + body) ? body : 0;
  }
  uint8_t buffer_[LONGEST + 1] = {};
  uint8_t count_ = 0, size_ = 0;
  static_assert(LONGEST <= 250, "a frame is counted in one byte");
};

}  // namespace tendril
