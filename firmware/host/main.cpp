// The firmware as a process: its serial line is a pseudo-terminal, its valves and sensors are words in a file (shared.h).
//   tendril-board FILE [--boot N] [--baud N]
// Prints the path of its terminal, again after each plug. Bytes on stdin: u pulls the cable, p plugs it in, r resets the
// board, h cuts the next reply in half. Ends with stdin. --baud changes nothing: a pseudo-terminal has no speed.
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <vector>

#include "config.h"
#include "shared.h"

namespace {

using namespace tendril;

constexpr uint32_t STEP_US = 1000;

// The board's clock wraps 2 s after the start, so that every test that lasts has seen it.
uint32_t micros() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  static const int64_t first = t.tv_sec * 1000000LL + t.tv_nsec / 1000;
  return static_cast<uint32_t>(t.tv_sec * 1000000LL + t.tv_nsec / 1000 - first - 2000000);
}

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "%s: %s\n", what, std::strerror(errno));
  std::exit(1);
}

class Terminal {
 public:
  void plug() {
    if (master_ >= 0) return;
    master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master_ < 0 || grantpt(master_) || unlockpt(master_)) fail("no pseudo-terminal");
    const char* path = ptsname(master_);
    slave_ = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);  // kept, so that a host which comes and goes is no hang-up
    termios raw{};
    if (slave_ < 0 || tcgetattr(slave_, &raw)) fail(path);
    cfmakeraw(&raw);
    tcsetattr(slave_, TCSANOW, &raw);
    std::puts(path);
    std::fflush(stdout);
  }
  void unplug() {
    if (master_ < 0) return;
    close(slave_);
    close(master_);
    master_ = slave_ = -1;
  }
  int descriptor() const { return master_; }
  long receive(uint8_t* bytes, size_t size) const { return read(master_, bytes, size); }
  // What the host does not take in time is lost, as on a wire.
  void send(const uint8_t* bytes, size_t size) const {
    if (write(master_, bytes, size) < 0 && errno != EAGAIN) fail("the terminal is lost");
  }

 private:
  int master_ = -1, slave_ = -1;
};

Shared* share(const char* path) {
  const int file = open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) fail(path);
  void* at = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (at == MAP_FAILED) fail(path);
  close(file);
  auto* shared = static_cast<Shared*>(at);
  if (shared->magic.load() != SHARED_MAGIC) {
    std::fprintf(stderr, "%s is not shared by a plant\n", path);
    std::exit(1);
  }
  return shared;
}

// An answer that is held back, and when it leaves.
struct Held {
  uint32_t due;
  std::vector<uint8_t> bytes;
};

class Process {
 public:
  Process(Shared* shared, uint16_t boot) : shared_(shared), boot_(boot), board_(HOST_CONFIG, boot, micros()) {}

  int run() {
    terminal_.plug();
    step();
    for (uint32_t due = micros() + STEP_US;;) {
      const int32_t left = static_cast<int32_t>(due - micros());
      release();
      if (left <= 0) {
        step();
        due = left < -100 * static_cast<int32_t>(STEP_US) ? micros() + STEP_US : due + STEP_US;
      } else if (!wait(left)) {
        return 0;
      }
    }
  }

 private:
  // Serve what comes within `left` microseconds; false where stdin has ended.
  bool wait(int32_t left) {
    pollfd waiting[2] = {{0, POLLIN, 0}, {terminal_.descriptor(), POLLIN, 0}};
    const timespec timeout{0, left * 1000L};
    if (ppoll(waiting, 2, &timeout, nullptr) <= 0) return true;
    if (waiting[0].revents) return obey();
    if (waiting[1].revents & POLLIN) listen();
    return true;
  }

  void listen() {
    uint8_t bytes[256];
    const long count = terminal_.receive(bytes, sizeof bytes);
    for (long i = 0; i < count; ++i) {
      if (!board_.receive(bytes[i], micros())) continue;
      publish();
      const auto size = halve_ ? board_.reply_size() / 2 : board_.reply_size();
      const auto later = static_cast<uint32_t>(shared_->hold_back.load());
      held_.push_back({micros() + later, {board_.reply(), board_.reply() + size}});
      halve_ = false;
    }
    release();
  }

  // Send what is due, in its order.
  void release() {
    while (!held_.empty() && static_cast<int32_t>(micros() - held_.front().due) >= 0) {
      terminal_.send(held_.front().bytes.data(), held_.front().bytes.size());
      held_.pop_front();
    }
  }

  bool obey() {
    char asked = 0;
    if (read(0, &asked, 1) <= 0) return false;
    if (asked == 'u') {
      terminal_.unplug();
      held_.clear();
    }
    if (asked == 'p') terminal_.plug();
    if (asked == 'h') halve_ = true;
    if (asked == 'r') {
      board_ = HostBoard(HOST_CONFIG, ++boot_, micros());
      step();
    }
    return true;
  }

  void step() {
    int32_t pressures[HOST_CHANNELS];
    for (int i = 0; i < HOST_CHANNELS; ++i) pressures[i] = sensed(shared_->pressures[i].load());
    board_.step(micros(), pressures, shared_->e_stop.load() != 0);
    publish();
    shared_->steps.fetch_add(1);
  }

  static int32_t sensed(int64_t pressure) {
    return pressure < -10000000 || pressure > 10000000 ? BROKEN : static_cast<int32_t>(pressure);
  }

  void publish() {
    const Outputs& out = board_.outputs();
    if (out.vent && !vented_) shared_->vented.store(micros());
    vented_ = out.vent;
    for (uint8_t i = 0; i < HOST_CHANNELS; ++i) {
      shared_->setpoints[i].store(board_.setpoint(i));
      shared_->openings[i].store(board_.opening(i));
    }
    shared_->last_command.store(board_.last_command());
    shared_->rejected.store(board_.rejected());
    shared_->boot.store(boot_);
    shared_->reasons.store(board_.reasons());
    shared_->flags.store((out.vent ? VENTED : 0) | (out.cut ? SUPPLY_CUT : 0) | (out.raw ? TAKES_RAW : 0));
  }

  Shared* shared_;
  Terminal terminal_;
  uint16_t boot_;
  HostBoard board_;
  std::deque<Held> held_;
  bool vented_ = false, halve_ = false;
};

}  // namespace

int main(int count, char** words) {
  if (count < 2 || count % 2 != 0) {
    std::fputs("usage: tendril-board FILE [--boot N] [--baud N]\n", stderr);
    return 2;
  }
  uint16_t boot = 1;
  for (int i = 2; i < count; i += 2) {
    if (!std::strcmp(words[i], "--boot")) boot = static_cast<uint16_t>(std::atoi(words[i + 1]));
  }
  static Process process(share(words[1]), boot);
  return process.run();
}
