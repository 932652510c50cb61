// What a valve board does, on no board in particular: bytes and pressures in, valve openings and replies out.
// Time is the board's, in microseconds, and may wrap. Nothing is allocated, and nothing waits.
#pragma once
#include "frame_reader.h"
#include "pressure_loop.h"

namespace tendril {

#ifndef TENDRIL_WATCHDOG_MS
#define TENDRIL_WATCHDOG_MS 100  // no board has another; the host build may, on a machine that pauses
#endif
constexpr uint32_t WATCHDOG_US = TENDRIL_WATCHDOG_MS * 1000UL;  // without a valid command: vent
constexpr uint8_t IN_A_ROW = 3;           // readings that must agree before one of them stops the board

struct Config {
  const char* name;        // at most 16 letters
  uint8_t capabilities;    // Capability
  int32_t pressure_min;    // [Pa] setpoints are held between these two
  int32_t pressure_max;
  int32_t pressure_trip;   // [Pa] above it: vent, cut the supply, stay stopped
  uint32_t slew_max;       // [Pa/ms] of setpoints, at most 400000
  Gains gains;
};

struct Outputs {
  bool vent, cut, raw;
};

template <uint8_t CHANNELS>
class Board {
  static_assert(CHANNELS >= 1 && CHANNELS <= CHANNELS_MAX, "docs/serial.md has 1 to 16 channels");

 public:
  Board(const Config& config, uint16_t boot, uint32_t now) : config_(&config), boot_(boot), last_command_(now) {
    vent_all();
  }

  // Take a byte of the host's; true where a reply is due, which then lies in `reply()`.
  bool receive(uint8_t byte, uint32_t now) {
    if (!reader_.push(byte)) return false;
    if (act(reader_.frame(), reader_.size(), now)) return true;
    ++rejected_;
    return other_version(now);
  }
  const uint8_t* reply() const { return wire_; }
  uint8_t reply_size() const { return wire_size_; }

  // Once a millisecond: gauge pressures [Pa] or BROKEN, read at `now`, and whether the hardware stop is pressed.
  void step(uint32_t now, const int32_t (&pressures)[CHANNELS], bool e_stop) {
    const uint32_t elapsed = now - read_at_;
    read_at_ = now;
    e_stop_ = e_stop;
    for (uint8_t i = 0; i < CHANNELS; ++i) look_at(i, pressures[i]);
    if (reasons_ == 0 && now - last_command_ > WATCHDOG_US) reasons_ = WATCHDOG;
    reasons_ = static_cast<uint8_t>(reasons_ | trouble());
    if (reasons_ & (OVER_PRESSURE | E_STOP_INPUT)) out_.cut = true;
    if (venting()) {
      vent_all();
    } else {
      drive(elapsed > 10000 ? 10000 : elapsed);
    }
  }

  const Outputs& outputs() const { return out_; }
  int16_t opening(uint8_t i) const { return openings_[i]; }   // 1/32767; negative exhausts
  int32_t setpoint(uint8_t i) const { return setpoints_[i]; }  // [Pa] slewed and limited
  uint8_t reasons() const { return reasons_; }                 // Reason; 0: it obeys
  uint32_t rejected() const { return rejected_; }
  uint32_t last_command() const { return last_command_; }

 private:
  static constexpr uint8_t LONGEST = command_size(CHANNELS) > HELLO_SIZE ? command_size(CHANNELS) : HELLO_SIZE;
  static constexpr uint8_t REPLY = state_size(CHANNELS) > HELLO_REPLY_SIZE ? state_size(CHANNELS) : HELLO_REPLY_SIZE;

  bool act(const uint8_t* frame, uint8_t size, uint32_t now) {
    if (size < HELLO_SIZE - CRC_SIZE || frame[0] != PROTOCOL) return false;
    if (frame[1] == HELLO && size == HELLO_SIZE - CRC_SIZE) return greet(frame, now);
    if (frame[1] == COMMAND && size == command_size(CHANNELS) - CRC_SIZE) return command(frame, now);
    return false;
  }

  // A host of another version learns which one this is; nothing else comes of it.
  bool other_version(uint32_t now) {
    const uint8_t* frame = reader_.frame();
    if (reader_.size() < HELLO_SIZE - CRC_SIZE || frame[0] == PROTOCOL || frame[1] != HELLO) return false;
    write_hello(frame, now);
    return true;
  }

  // Who begins must vent first, also where another host drove until now.
  bool greet(const uint8_t* frame, uint32_t now) {
    sequence_ = u16_at(frame + 2);
    greeted_ = true;
    reasons_ = static_cast<uint8_t>(reasons_ | GREETED);
    vent_all();
    write_hello(frame, now);
    return true;
  }

  bool command(const uint8_t* frame, uint32_t now) {
    const uint16_t sequence = u16_at(frame + 2);
    if (greeted_ && static_cast<int16_t>(sequence - sequence_) <= 0) return false;  // a repetition, or old
    if (!sound(frame)) return false;
    sequence_ = sequence;
    greeted_ = true;
    last_command_ = now;
    take(frame);
    write_state(frame, now);
    return true;
  }

  static bool sound(const uint8_t* frame) {
    const uint8_t wanted = frame[8];
    const uint16_t driven = u16_at(frame + 10);
    const int32_t end = wanted & RAW ? OPENING_END : SETPOINT_END;
    if ((wanted & ~WANTED_ALL) || frame[9] != CHANNELS || (static_cast<uint32_t>(driven) >> CHANNELS)) return false;
    for (uint8_t i = 0; i < CHANNELS; ++i) {
      const int32_t target = i32_at(frame + 12 + 4 * i);
      if (target > end || target < -end || (target != 0 && !(driven >> i & 1))) return false;
    }
    return true;
  }

  void take(const uint8_t* frame) {
    wanted_ = frame[8];
    driven_ = wanted_ & VENT ? 0 : u16_at(frame + 10);
    if (wanted_ & VENT) reasons_ = trouble();  // what led here is over, or it is not
    out_.cut = (wanted_ & CUT) || (reasons_ & (BOOT | OVER_PRESSURE | E_STOP_INPUT));
    if (out_.raw != static_cast<bool>(wanted_ & RAW)) vent_all();  // no setpoint becomes an opening
    out_.raw = wanted_ & RAW;
    for (uint8_t i = 0; i < CHANNELS; ++i) targets_[i] = i32_at(frame + 12 + 4 * i);
    if (venting()) vent_all();
  }

  bool venting() const { return reasons_ || (wanted_ & (VENT | CUT)); }

  void look_at(uint8_t i, int32_t pressure) {
    pressures_[i] = pressure;
    count(over_[i], pressure > config_->pressure_trip);
    count(broken_[i], pressure == BROKEN);
  }

  static void count(uint8_t& in_a_row, bool yes) {
    in_a_row = !yes ? 0 : in_a_row < IN_A_ROW ? static_cast<uint8_t>(in_a_row + 1) : in_a_row;
  }

  // What stops the board as things are now.
  uint8_t trouble() const {
    uint8_t found = static_cast<uint8_t>(e_stop_ ? +E_STOP_INPUT : 0);
    for (uint8_t i = 0; i < CHANNELS; ++i) {
      if (over_[i] >= IN_A_ROW) found = static_cast<uint8_t>(found | OVER_PRESSURE);
      if (broken_[i] >= IN_A_ROW && (driven_ >> i & 1)) found = static_cast<uint8_t>(found | BROKEN_SENSOR);
    }
    return found;
  }

  void vent_all() {
    out_.vent = true;
    limited_ = false;
    for (uint8_t i = 0; i < CHANNELS; ++i) exhaust(i);
  }

  void exhaust(uint8_t i) {
    openings_[i] = -OPENING_END;
    setpoints_[i] = 0;
    loops_[i].reset();
  }

  void drive(uint32_t elapsed) {
    const int32_t slew = static_cast<int32_t>(config_->slew_max * elapsed / 1000);
    out_.vent = limited_ = false;
    for (uint8_t i = 0; i < CHANNELS; ++i) {
      if (!(driven_ >> i & 1)) {
        exhaust(i);
      } else if (out_.raw) {
        openings_[i] = below_end(i, static_cast<int16_t>(targets_[i]));
      } else {
        setpoints_[i] = slewed(setpoints_[i], within(targets_[i]), slew);
        if (pressures_[i] == BROKEN) continue;  // keeps its opening until the third of them stops the board
        openings_[i] = below_end(i, loops_[i].step(setpoints_[i] - pressures_[i], config_->gains));
      }
    }
  }

  // Never fills a chamber that has its largest pressure.
  int16_t below_end(uint8_t i, int16_t opening) {
    if (opening <= 0 || pressures_[i] < config_->pressure_max) return opening;
    if (out_.raw) limited_ = true;
    return 0;
  }

  int32_t within(int32_t target) {
    const int32_t held = target > config_->pressure_max   ? config_->pressure_max
                         : target < config_->pressure_min ? config_->pressure_min
                                                         : target;
    if (held != target) limited_ = true;
    return held;
  }

  static int32_t slewed(int32_t from, int32_t to, int32_t most) {
    return to > from + most ? from + most : to < from - most ? from - most : to;
  }

  void write_hello(const uint8_t* asked, uint32_t now) {
    uint8_t frame[HELLO_REPLY_SIZE];
    Writer w(frame);
    write_head(w, HELLO_REPLY, asked, now);
    w.u16(FIRMWARE);
    w.u16(boot_);
    w.u8(CHANNELS);
    w.u8(config_->capabilities);
    w.u16(static_cast<uint16_t>(WATCHDOG_US / 1000));
    w.i32(config_->pressure_max);
    w.i32(config_->pressure_trip);
    w.u32(config_->slew_max * 1000);
    w.text(config_->name, NAME_SIZE);
    wire_size_ = seal(frame, w.size(), wire_);
  }

  void write_state(const uint8_t* asked, uint32_t now) {
    uint8_t frame[state_size(CHANNELS)];
    Writer w(frame);
    write_head(w, STATE, asked, now);
    w.u32(read_at_);
    w.u16(boot_);
    w.u16(static_cast<uint16_t>(rejected_));
    w.u8(reasons_);
    w.u8(static_cast<uint8_t>((out_.vent ? VENTED : 0) | (out_.cut ? SUPPLY_CUT : 0) | (out_.raw ? TAKES_RAW : 0) |
                              (limited_ ? LIMITED : 0)));
    w.u8(CHANNELS);
    w.u8(0);
    for (uint8_t i = 0; i < CHANNELS; ++i) w.i32(pressures_[i]);
    wire_size_ = seal(frame, w.size(), wire_);
  }

  static void write_head(Writer& w, Type type, const uint8_t* asked, uint32_t now) {
    w.u8(PROTOCOL);
    w.u8(type);
    w.u16(u16_at(asked + 2));
    w.u32(u32_at(asked + 4));
    w.u32(now);
  }

  const Config* config_;
  FrameReader<LONGEST> reader_;
  uint8_t wire_[on_wire(REPLY)] = {};
  uint8_t wire_size_ = 0;
  PressureLoop loops_[CHANNELS];
  int32_t targets_[CHANNELS] = {}, setpoints_[CHANNELS] = {}, pressures_[CHANNELS] = {};
  int16_t openings_[CHANNELS] = {};
  uint8_t over_[CHANNELS] = {}, broken_[CHANNELS] = {};
  Outputs out_ = {true, true, false};  // no air before a host is there, and has vented
  uint16_t boot_, sequence_ = 0, driven_ = 0;
  uint32_t last_command_, read_at_ = 0, rejected_ = 0;
  uint8_t wanted_ = VENT, reasons_ = BOOT;
  bool greeted_ = false, limited_ = false, e_stop_ = false;
};

}  // namespace tendril
