#include "child_process.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <utility>

namespace quoin::referee {
namespace {

struct Pipe {
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe to a plug-in can be made");
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
    if (end >= 0) ::close(end);
    end = -1;
  }
};

/// A library may take half of the machine's memory. Not under AddressSanitizer, which maps far more
/// than it uses.
void limit_memory() {
  if (::dlsym(RTLD_DEFAULT, "__asan_init") == nullptr) {
    const auto half = static_cast<rlim_t>(::sysconf(_SC_PHYS_PAGES)) / 2 *
                      static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
    const rlimit limit{half, half};
    ::setrlimit(RLIMIT_AS, &limit);
  }
}

/// The child ends with its parent `parent`, even in the middle of a hang, and leaves it to it what
/// Ctrl-C means.
void depend_on(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int number : {SIGINT, SIGHUP}) ::signal(number, SIG_IGN);
  for (const int number : {SIGTERM, SIGPIPE}) ::signal(number, SIG_DFL);
}

void be_quiet() {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  const int nowhere = ::open("/dev/null", O_WRONLY);
  ::dup2(nowhere, STDOUT_FILENO);  // libraries talk
  ::dup2(nowhere, STDERR_FILENO);
}

/// Answers until the pipe is closed.
[[noreturn]] void serve(const std::function<ChildProcess::Answer()>& start, int from, int to) {
  be_quiet();
  try {
    const ChildProcess::Answer answer = start();
    for (;;) {
      Message question;
      if (question.receive(from, -1) != Message::Received::Whole || !answer(question).send(to))
        ::_exit(0);
    }
  } catch (...) {
    ::_exit(1);
  }
}

}  // namespace

ChildProcess::ChildProcess(std::function<Answer()> start, std::chrono::milliseconds limit)
    : start_(std::move(start)), limit_(limit) {}

ChildProcess::~ChildProcess() { stop(); }

void ChildProcess::fork_child() {
  Pipe there, back;
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ < 0) throw std::runtime_error("no process for a plug-in can be started");
  ::signal(SIGPIPE, SIG_IGN);  // a child that has ended is told by send()
  if (process_ == 0) {
    depend_on(parent);
    limit_memory();
    there.close_write_end();
    back.close_read_end();
    serve(start_, there.read_end, back.write_end);
  }
  to_ = there.take_write_end();
  from_ = back.take_read_end();
}

void ChildProcess::stop() {
  if (process_ < 0) return;
  ::close(to_);
  ::close(from_);
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {  // Ctrl-C may come just now
  }
  process_ = -1;
}

Message::Received ChildProcess::ask(const Message& question, Message& reply) {
  if (!running()) fork_child();
  const Message::Received received = question.send(to_)
                                         ? reply.receive(from_, static_cast<int>(limit_.count()))
                                         : Message::Received::Closed;
  if (received != Message::Received::Whole) stop();
  return received;
}

}  // namespace quoin::referee
