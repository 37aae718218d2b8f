#include "plugin.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <quoin/referee.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "described_solid.hpp"
#include "message.hpp"

namespace quoin::referee {
namespace {

using geometry::Placement;
using geometry::Points;
using tests::Solid;

using Entry = const quoin_referee_library* (*)(int);

constexpr int kMostPoints = 4096;         // contact points of one answer
constexpr int kLoadMilliseconds = 10000;  // for a plug-in to be loaded

struct Pipe {
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe to a plug-in can be made");
    }
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close_read_end();
    close_write_end();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read_end() { close(read_end); }
  void close_write_end() { close(write_end); }
  int take_read_end() { return std::exchange(read_end, -1); }
  int take_write_end() { return std::exchange(write_end, -1); }
  int read_end = -1, write_end = -1;

 private:
  static void close(int& end) {
    if (end >= 0) {
      ::close(end);
    }
    end = -1;
  }
};

/// Null and a line in `wrong`, where there is no such library.
const quoin_referee_library* load(const std::string& file, int index, std::string& wrong) {
  void* handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    wrong = ::dlerror();
    return nullptr;
  }
  const auto entry = reinterpret_cast<Entry>(::dlsym(handle, "quoin_referee_plugin"));
  if (entry == nullptr) {
    wrong = file + ": no function quoin_referee_plugin";
    return nullptr;
  }
  const quoin_referee_library* library = entry(index);
  if (library != nullptr && library->interface != QUOIN_REFEREE_INTERFACE) {
    wrong = file + ": interface " + std::to_string(library->interface) + ", must be " +
            std::to_string(QUOIN_REFEREE_INTERFACE);
    return nullptr;
  }
  return library;
}

/// What the child holds of a sequence of questions.
class Server {
 public:
  explicit Server(const quoin_referee_library& library) : library_(library) {}

  Message answer(Message& question) {
    goes_on_ = question.take_integer() != 0;
    for (Side& side : sides_) {
      read(question, goes_on_, side);
    }
    if (!goes_on_) {
      forget();
    }
    Message reply;
    try {
      write_answer(reply);
    } catch (...) {
      reply = {};
      reply.add(static_cast<int>(Outcome::Failed));
    }
    return reply;
  }

 private:
  struct Side {
    std::optional<DescribedSolid> solid;
    quoin_referee_placement placement{};
    void* made = nullptr;
  };

  static void read(Message& message, bool goes_on, Side& side) {
    const int count = message.take_integer();
    Points points(3, count);
    message.take_all(points);
    Placement placement;
    message.take_all(placement.linear);
    message.take_all(placement.translation);
    side.placement = described(placement);
    if (!goes_on) {
      side.solid.emplace(points);
    }
  }

  void forget() {
    for (Side& side : sides_) {
      if (side.made != nullptr) {
        library_.free_solid(side.made);
      }
      side.made = nullptr;
    }
    if (memory_ != nullptr) {
      library_.free_memory(memory_);
    }
    memory_ = nullptr;
  }

  bool make(Side& side) {
    if (side.made == nullptr) {
      const quoin_referee_solid view = side.solid->view();
      side.made = library_.make_solid(&view);
    }
    return side.made != nullptr;
  }

  void write_answer(Message& reply) {
    if (!make(sides_[0]) || !make(sides_[1])) {
      reply.add(
          static_cast<int>(sides_[0].made == nullptr ? Outcome::RefusedA : Outcome::RefusedB));
      return;
    }
    if (memory_ == nullptr && library_.make_memory != nullptr) {
      memory_ = library_.make_memory();
    }
    quoin_referee_answer answer{};
    quoin_referee_status status = QUOIN_REFEREE_NO_ANSWER;
    double seconds = timed_ask(memory_, answer, status);
    if (!goes_on_) {
      seconds = median_of_cold_asks();
    }
    reply.add(static_cast<int>(outcome(status)));
    reply.add(seconds);
    reply.add(answer.gap);
    for (const double* three : {answer.normal, answer.point_a, answer.point_b}) {
      for (int k = 0; k < 3; ++k) {
        reply.add(three[k]);
      }
    }
    list_points(reply);
  }

  double timed_ask(void* memory, quoin_referee_answer& answer, quoin_referee_status& status) {
    const auto start = std::chrono::steady_clock::now();
    library_.set_placement(sides_[0].made, &sides_[0].placement);
    library_.set_placement(sides_[1].made, &sides_[1].placement);
    status = library_.ask(sides_[0].made, sides_[1].made, memory, &answer);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  /// The library's code is in the caches then; what it knows of the pair is not.
  double median_of_cold_asks() {
    std::array<double, 5> seconds;
    quoin_referee_answer answer{};
    quoin_referee_status status{};
    for (double& s : seconds) {
      s = timed_ask(nullptr, answer, status);
    }
    std::nth_element(seconds.begin(), seconds.begin() + 2, seconds.end());
    return seconds[2];
  }

  void list_points(Message& reply) {
    if (library_.list_points == nullptr) {
      reply.add(static_cast<int>(Outcome::NoAnswer));
      return;
    }
    points_.resize(kMostPoints);
    int count = kMostPoints;
    const quoin_referee_status status =
        library_.list_points(sides_[0].made, sides_[1].made, memory_, points_.data(), &count);
    reply.add(static_cast<int>(outcome(status)));
    count = std::clamp(count, 0, kMostPoints);
    reply.add(count);
    for (int i = 0; i < count; ++i) {
      const quoin_referee_point& point = points_[static_cast<std::size_t>(i)];
      for (const double* three : {point.point_a, point.point_b}) {
        for (int k = 0; k < 3; ++k) {
          reply.add(three[k]);
        }
      }
      reply.add(point.gap);
      reply.add(point.area);
    }
  }

  static Outcome outcome(quoin_referee_status status) {
    switch (status) {
      case QUOIN_REFEREE_ANSWERED:
        return Outcome::Answered;
      case QUOIN_REFEREE_NO_ANSWER:
        return Outcome::NoAnswer;
      default:
        return Outcome::Failed;
    }
  }

  const quoin_referee_library& library_;
  Side sides_[2];
  void* memory_ = nullptr;
  bool goes_on_ = false;
  std::vector<quoin_referee_point> points_;
};

/// The child: answers until the pipe is closed.
[[noreturn]] void serve(const LibraryInfo& info, int from, int to) {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::signal(SIGPIPE, SIG_DFL);
  const int nowhere = ::open("/dev/null", O_WRONLY);
  ::dup2(nowhere, STDOUT_FILENO);  // libraries talk
  ::dup2(nowhere, STDERR_FILENO);
  std::string wrong;
  const quoin_referee_library* library = load(info.file, info.index, wrong);
  if (library == nullptr) {
    ::_exit(1);
  }
  Server server(*library);
  for (;;) {
    Message question;
    if (question.receive(from, -1) != Message::Received::Whole ||
        !server.answer(question).send(to)) {
      ::_exit(0);
    }
  }
}

void add(Message& message, const std::string& text) {
  message.add(static_cast<double>(text.size()));
  for (const char c : text) {
    message.add(c);
  }
}

std::string take_text(Message& message) {
  std::string text(static_cast<std::size_t>(message.take_integer()), ' ');
  for (char& c : text) {
    c = static_cast<char>(message.take_integer());
  }
  return text;
}

/// A child that tells what libraries a plug-in has: the number of them and each, or -1 and what is
/// wrong.
[[noreturn]] void describe(const std::string& file, int to) {
  Message told;
  std::string wrong;
  std::vector<const quoin_referee_library*> libraries;
  while (const auto* library = load(file, static_cast<int>(libraries.size()), wrong)) {
    libraries.push_back(library);
  }
  if (wrong.empty() && libraries.empty()) {
    wrong = file + ": it has no library";
  }
  told.add(wrong.empty() ? static_cast<double>(libraries.size()) : -1);
  if (!wrong.empty()) {
    add(told, wrong);
  }
  for (const quoin_referee_library* library : libraries) {
    add(told, library->name);
    add(told, library->version);
    told.add(library->offers);
    told.add(library->promised_error);
  }
  told.send(to);
  ::_exit(0);
}

std::vector<LibraryInfo> read_libraries(const std::string& file, Message& told) {
  const int count = told.take_integer();
  if (count < 0) {
    throw std::runtime_error(take_text(told));
  }
  std::vector<LibraryInfo> list;
  for (int index = 0; index < count; ++index) {
    LibraryInfo info{file, index, take_text(told), take_text(told), 0, 0};
    info.offers = told.take_integer();
    info.promised_error = told.take();
    list.push_back(info);
  }
  return list;
}

pid_t fork_or_throw() {
  const pid_t process = ::fork();
  if (process < 0) {
    throw std::runtime_error("no process for a plug-in can be started");
  }
  return process;
}

void add(Message& message, const Solid& solid) {
  message.add(static_cast<double>(solid.placed.points.cols()));
  message.add_all(solid.placed.points);
  message.add_all(solid.placed.placement.linear);
  message.add_all(solid.placed.placement.translation);
}

Answer read_answer(Message& reply) {
  Answer answer;
  answer.outcome = static_cast<Outcome>(reply.take_integer());
  answer.seconds = reply.take();
  answer.gap = reply.take();
  reply.take_all(answer.normal);
  reply.take_all(answer.point_a);
  reply.take_all(answer.point_b);
  answer.points_outcome = static_cast<Outcome>(reply.take_integer());
  answer.points.resize(static_cast<std::size_t>(reply.take_integer()));
  for (ListedPoint& point : answer.points) {
    reply.take_all(point.point_a);
    reply.take_all(point.point_b);
    point.gap = reply.take();
    point.area = reply.take();
  }
  return answer;
}

}  // namespace

std::vector<LibraryInfo> libraries_of(const std::string& file) {
  Pipe pipe;
  const pid_t process = fork_or_throw();
  if (process == 0) {
    describe(file, pipe.write_end);
  }
  pipe.close_write_end();
  Message told;
  const Message::Received received = told.receive(pipe.read_end, kLoadMilliseconds);
  ::kill(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
  if (received != Message::Received::Whole) {
    throw std::runtime_error(file + ": the plug-in ends or blocks the process that loads it");
  }
  return read_libraries(file, told);
}

Plugin::Plugin(LibraryInfo info, std::chrono::milliseconds limit)
    : info_(std::move(info)), limit_(limit) {}

Plugin::~Plugin() { stop(); }

void Plugin::start() {
  Pipe there, back;
  process_ = fork_or_throw();
  if (process_ == 0) {
    there.close_write_end();
    back.close_read_end();
    serve(info_, there.read_end, back.write_end);
  }
  to_ = there.take_write_end();
  from_ = back.take_read_end();
}

void Plugin::stop() {
  if (process_ < 0) {
    return;
  }
  ::close(to_);
  ::close(from_);
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

Answer Plugin::ask(const Question& question) {
  const bool fresh = process_ < 0;
  if (fresh) {
    start();
  }
  Message message;
  message.add(question.goes_on && !fresh ? 1 : 0);
  add(message, question.pair.a);
  add(message, question.pair.b);
  Message reply;
  const Message::Received received = message.send(to_)
                                         ? reply.receive(from_, static_cast<int>(limit_.count()))
                                         : Message::Received::Closed;
  if (received == Message::Received::Whole) {
    return read_answer(reply);
  }
  stop();
  Answer answer;
  answer.outcome = received == Message::Received::Closed ? Outcome::Crashed : Outcome::TimedOut;
  return answer;
}

}  // namespace quoin::referee
