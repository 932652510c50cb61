#pragma once
struct {
  template <typename T> void get(int, T&) {}
  template <typename T> void put(int, T) {}
} EEPROM;
