#pragma once
/// A child process that answers messages: it may crash or hang, and is started again.

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <memory>

#include "message.hpp"

namespace quoin::referee {

class ChildProcess {
 public:
  using Answer = std::function<Message(Message& question)>;

  /// What answers by Server(of).answer(question).
  template <class Server, class Argument>
  static Answer served_by(const Argument& of) {
    const auto server = std::make_shared<Server>(of);
    return [server](Message& question) { return server->answer(question); };
  }

  /// `start` runs in the child, and gives what answers there; it may throw, which ends the child.
  ChildProcess(std::function<Answer()> start, std::chrono::milliseconds limit);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// False: the next question goes to a child that knows nothing.
  bool running() const { return process_ >= 0; }
  /// Closed: the child ended; TimedOut: no reply within the limit. It is gone then.
  Message::Received ask(const Message& question, Message& reply);

 private:
  void fork_child();
  void stop();

  std::function<Answer()> start_;
  std::chrono::milliseconds limit_;
  pid_t process_ = -1;
  int to_ = -1, from_ = -1;
};

}  // namespace quoin::referee
