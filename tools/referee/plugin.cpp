#include "plugin.hpp"

#include <stdexcept>
#include <utility>

#include "library_session.hpp"

namespace quoin::referee {
namespace {

constexpr std::chrono::milliseconds kLoadLimit{10000};  // for a plug-in to be loaded
constexpr std::size_t kMostLibraries = 1000;            // of one plug-in

void add_text(const std::string& text, Message& message) {
  message.add(static_cast<double>(text.size()));
  for (const char c : text) message.add(c);
}

std::string take_text(Message& message) {
  std::string text(message.take_count(), ' ');
  for (char& c : text) {
    const int code = message.take_integer();
    c = code >= ' ' && code <= '~' ? static_cast<char>(code) : '?';
  }
  return text;
}

/// What libraries a plug-in has: the number of them and each, or -1 and what is wrong.
Message description_of(const std::string& file) {
  Message told;
  try {
    std::vector<const quoin_referee_library*> libraries;
    while (const auto* library = load_library(file, static_cast<int>(libraries.size()))) {
      libraries.push_back(library);
      if (libraries.size() > kMostLibraries) {
        throw std::runtime_error(file +
                                 ": quoin_referee_plugin returns no null behind its last library");
      }
    }
    if (libraries.empty()) throw std::runtime_error(file + ": it has no library");
    told.add(static_cast<double>(libraries.size()));
    for (const quoin_referee_library* library : libraries) {
      add_text(library->name, told);
      add_text(library->version, told);
      told.add(library->offers);
      told.add(library->promised_error);
    }
  } catch (const std::exception& error) {
    told = {};
    told.add(-1);
    add_text(error.what(), told);
  }
  return told;
}

Outcome outcome_of(quoin_referee_status status) {
  switch (status) {
    case QUOIN_REFEREE_ANSWERED:
      return Outcome::Answered;
    case QUOIN_REFEREE_NO_ANSWER:
      return Outcome::NoAnswer;
    default:
      return Outcome::Failed;
  }
}

void add_three(const double* three, Message& message) {
  for (int k = 0; k < 3; ++k) message.add(three[k]);
}

/// In the child: a question to its library.
class AnswerServer {
 public:
  explicit AnswerServer(const LibraryInfo& info) : session_(*load_library(info.file, info.index)) {}

  Message answer(Message& question) {
    posed_.read(question);
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
  void write_answer(Message& reply) {
    const Outcome taken = session_.take(posed_);
    if (taken != Outcome::Answered) {
      reply.add(static_cast<int>(taken));
      return;
    }
    constexpr auto kMemory = LibrarySession::Memory::Kept;
    quoin_referee_answer answer{};
    session_.move();
    reply.add(static_cast<int>(outcome_of(session_.ask(kMemory, answer))));
    reply.add(answer.gap);
    add_three(answer.normal, reply);
    add_three(answer.point_a, reply);
    add_three(answer.point_b, reply);
    const ListedPoints listed = session_.list_points(kMemory);
    reply.add(static_cast<int>(outcome_of(listed.status)));
    reply.add(static_cast<double>(listed.points.size()));
    for (const quoin_referee_point& point : listed.points) {
      add_three(point.point_a, reply);
      add_three(point.point_b, reply);
      reply.add(point.gap);
      reply.add(point.area);
    }
  }

  LibrarySession session_;
  PosedQuestion posed_;
};

Answer read_answer(Message& reply) {
  Answer answer;
  answer.outcome = static_cast<Outcome>(reply.take_integer());
  answer.gap = reply.take();
  reply.take_all(answer.normal);
  reply.take_all(answer.point_a);
  reply.take_all(answer.point_b);
  answer.points_outcome = static_cast<Outcome>(reply.take_integer());
  answer.points.resize(reply.take_count(8));
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
  ChildProcess process([&] { return [&](Message&) { return description_of(file); }; }, kLoadLimit);
  Message told;
  if (process.ask({}, told) != Message::Received::Whole)
    throw std::runtime_error(file + ": the plug-in ends or blocks the process that loads it");
  const int count = told.take_integer();
  if (count < 0) throw std::runtime_error(take_text(told));
  std::vector<LibraryInfo> list;
  for (int index = 0; index < count; ++index) {
    LibraryInfo info{file, index, take_text(told), take_text(told), 0, 0};
    info.offers = told.take_integer();
    info.promised_error = told.take();
    list.push_back(info);
  }
  return list;
}

Plugin::Plugin(LibraryInfo info, std::chrono::milliseconds limit)
    : info_(std::move(info)),
      process_([this] { return ChildProcess::served_by<AnswerServer>(info_); }, limit) {}

Answer Plugin::ask(const Question& question) {
  Message message, reply;
  const bool goes_on = process_.running() && solids_ == question.solids;
  solids_ = question.solids;
  PosedQuestion::write(question, goes_on, message);
  switch (process_.ask(message, reply)) {
    case Message::Received::Whole:
      return read_answer(reply);
    case Message::Received::Closed:
      return Answer{.outcome = Outcome::Crashed};
    default:
      return Answer{.outcome = Outcome::TimedOut};
  }
}

}  // namespace quoin::referee
