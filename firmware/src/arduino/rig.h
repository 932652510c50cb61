// The core on a board that Arduino's functions describe: analogRead, digital and PWM pins, a serial port, EEPROM.
#pragma once
#include <Arduino.h>
#include <EEPROM.h>

#include "../core/board.h"
#include "watchdog.h"

namespace tendril {

// A linear sensor: `zero` counts at 0 Pa gauge, `scale` Pa per 1024 counts; outside `least` to `most` it is broken.
struct Sensor {
  uint8_t pin;
  int16_t zero, least, most;
  int32_t scale;
  int32_t read() const {
    const int16_t counts = static_cast<int16_t>(analogRead(pin));
    if (counts < least || counts > most) return BROKEN;
    return static_cast<int32_t>(counts - zero) * (scale / 32) / 32;  // in 32 bits up to 60 MPa
  }
};

// A pair of valves. The exhaust is one that is open without current: a board without power vents.
struct ValvePair {
  uint8_t inflate_pin, exhaust_pin;
  bool pwm;  // proportional valves at hardware PWM; else on-off valves, switched in a period of 16 ms

  void begin() const {
    pinMode(inflate_pin, OUTPUT);
    pinMode(exhaust_pin, OUTPUT);
    set(-OPENING_END, 0);
  }
  void set(int16_t opening, uint8_t slot) const {
    const int16_t fills = opening > 0 ? opening : 0;
    const int16_t empties = opening < 0 ? static_cast<int16_t>(-opening) : 0;
    if (pwm) {
      analogWrite(inflate_pin, fills >> 7);
      analogWrite(exhaust_pin, 255 - (empties >> 7));
    } else {
      digitalWrite(inflate_pin, on(fills, slot) ? HIGH : LOW);
      digitalWrite(exhaust_pin, on(empties, slot) ? LOW : HIGH);
    }
  }

 private:
  // Of 16 slots of 1 ms, the first that make up the opening; none below 1/32, all above 31/32.
  static bool on(int16_t opening, uint8_t slot) { return ((opening >> 4) + 64) >> 7 > (slot & 15); }
};

template <uint8_t CHANNELS>
struct Wiring {
  Sensor sensors[CHANNELS];
  ValvePair valves[CHANNELS];
  uint8_t supply_pin;  // HIGH lets air in; the supply valve must be one that is closed without current
  uint8_t e_stop_pin;  // a normally closed contact to ground: open (HIGH), pressed or broken, stops
};

constexpr uint8_t LISTEN_MOST = 128;  // bytes that are taken in one go: more than any frame

// Runs the core: call `begin` in setup() and `poll` in loop().
template <uint8_t CHANNELS, typename Port>
class Rig {
 public:
  Rig(const Config& config, const Wiring<CHANNELS>& wiring, Port& port)
      : wiring_(wiring), port_(port), board_(config, 0, 0), config_(config) {}

  void begin() {
#if defined(__AVR__)
    ADCSRA = static_cast<uint8_t>((ADCSRA & ~7) | 5);  // four times faster: four sensors in 0.1 of each millisecond
#endif
    for (const ValvePair& pair : wiring_.valves) pair.begin();
    pinMode(wiring_.supply_pin, OUTPUT);
    vent();
    pinMode(wiring_.e_stop_pin, INPUT_PULLUP);
    board_ = Board<CHANNELS>(config_, next_boot(), micros());
    port_.begin(1000000);
    running() = this;
    watchdog_.begin([] { running()->vent(); });  // now: to note the start takes a Teensy's flash longer than a hang
    step();
  }

  void poll() {
    if (micros() - stepped_ >= 1000) step();
    listen();
  }

 private:
  // Bytes that form no frame must not keep the sensors from being read, however many come, and however fast. An AVR has
  // no time to count them: where they never end its watchdog resets it, and so vents.
  void listen() {
#if !defined(__AVR__)
    uint8_t left = LISTEN_MOST;
#endif
    for (int byte = port_.read(); byte >= 0; byte = port_.read()) {
      if (byte != 0) {
        board_.receive(static_cast<uint8_t>(byte), 0);  // only an end has a time
      } else if (board_.receive(0, micros())) {
        port_.write(board_.reply(), board_.reply_size());
        return;  // a host that never pauses must not keep the sensors from being read
      }
#if !defined(__AVR__)
      if (--left == 0) return;
#endif
    }
  }

  void step() {
    stepped_ = micros();
    int32_t pressures[CHANNELS];
    for (uint8_t i = 0; i < CHANNELS; ++i) {
      pressures[i] = wiring_.sensors[i].read();
      listen();  // the port keeps 64 bytes, which is 0.64 ms
    }
    board_.step(micros(), pressures, digitalRead(wiring_.e_stop_pin) == HIGH);
    ++slot_;
    apply();
    watchdog_.alive();
  }

  void vent() {
    for (const ValvePair& pair : wiring_.valves) pair.set(-OPENING_END, 0);
    digitalWrite(wiring_.supply_pin, LOW);
  }

  // What the watchdog vents: a board has one.
  static Rig*& running() {
    static Rig* rig = nullptr;
    return rig;
  }

  void apply() {
    for (uint8_t i = 0; i < CHANNELS; ++i) wiring_.valves[i].set(board_.opening(i), slot_);
    digitalWrite(wiring_.supply_pin, board_.outputs().cut ? LOW : HIGH);
  }

  static uint16_t next_boot() {
    uint16_t boot = 0;
    EEPROM.get(0, boot);
    ++boot;
    EEPROM.put(0, boot);
    return boot;
  }

  const Wiring<CHANNELS>& wiring_;
  Port& port_;
  Board<CHANNELS> board_;
  const Config& config_;
  Watchdog watchdog_;
  uint32_t stepped_ = 0;
  uint8_t slot_ = 0;
};

}  // namespace tendril
