#include "library_session.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <stdexcept>

namespace quoin::referee {
namespace {

using Entry = const quoin_referee_library* (*)(int);

constexpr int kMostPoints = 4096;  // contact points of one answer

template <class Integer>
void add_list(const std::vector<Integer>& list, Message& message) {
  message.add(static_cast<double>(list.size()));
  for (const Integer number : list) message.add(number);
}

std::vector<int> take_list(Message& message) {
  std::vector<int> list(message.take_count());
  std::generate(list.begin(), list.end(), [&] { return message.take_integer(); });
  return list;
}

void add(const DescribedSolid& solid, Message& message) {
  message.add(static_cast<double>(solid.points.cols()));
  message.add_all(solid.points);
  add_list(solid.face_sizes, message);
  add_list(solid.face_vertices, message);
  message.add_all(solid.box_centre);
  message.add_all(solid.box_half);
}

DescribedSolid take_solid(Message& message) {
  DescribedSolid solid;
  solid.points.resize(3, static_cast<Eigen::Index>(message.take_count(3)));
  message.take_all(solid.points);
  solid.face_sizes = take_list(message);
  solid.face_vertices = take_list(message);
  message.take_all(solid.box_centre);
  message.take_all(solid.box_half);
  return solid;
}

/// Throws std::runtime_error where a question could not be put.
void check(const quoin_referee_library& library, const std::string& which) {
  const auto require = [&](bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error(which + " " + what);
  };
  require(library.interface == QUOIN_REFEREE_INTERFACE,
          "has interface " + std::to_string(library.interface) + ", must be " +
              std::to_string(QUOIN_REFEREE_INTERFACE));
  require(library.name != nullptr && library.version != nullptr, "has no name or no version");
  require(library.promised_error >= 0 && library.promised_error < 1,
          "has a promised_error of " + std::to_string(library.promised_error) +
              ", must be a share of the diameter from 0 to below 1");
  require(library.make_solid != nullptr && library.free_solid != nullptr &&
              library.set_placement != nullptr,
          "lacks make_solid, free_solid or set_placement");
  require((library.make_memory == nullptr) == (library.free_memory == nullptr),
          "has one of make_memory and free_memory alone");
  const bool gaps =
      (library.offers & (QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_SIGN)) != 0;
  const bool points = (library.offers & QUOIN_REFEREE_POINTS) != 0;
  require(gaps || points, "offers neither gaps nor points");
  require(!gaps || library.ask != nullptr, "offers gaps without ask");
  require(!points || library.list_points != nullptr, "offers points without list_points");
}

}  // namespace

const quoin_referee_library* load_library(const std::string& file, int index) {
  // a bare name would be looked for among the system's libraries
  const std::string path = std::filesystem::absolute(file).string();
  void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw std::runtime_error(::dlerror());
  const auto entry = reinterpret_cast<Entry>(::dlsym(handle, "quoin_referee_plugin"));
  if (entry == nullptr) throw std::runtime_error(file + ": no function quoin_referee_plugin");
  const quoin_referee_library* library = entry(index);
  if (library != nullptr) check(*library, file + ": library " + std::to_string(index));
  return library;
}

void PosedQuestion::write(const Question& question, bool goes_on, Message& message) {
  message.add(goes_on ? 1 : 0);
  for (const Solid* solid : {&question.pair.a, &question.pair.b}) {
    message.add_all(solid->placed.placement.linear);
    message.add_all(solid->placed.placement.translation);
  }
  if (!goes_on) {
    add(question.solids->a, message);
    add(question.solids->b, message);
  }
}

void PosedQuestion::read(Message& message) {
  goes_on = message.take_integer() != 0;
  for (quoin_referee_placement& to : placements) {
    geometry::Placement placement;
    message.take_all(placement.linear);
    message.take_all(placement.translation);
    to = described(placement);
  }
  if (!goes_on) {
    solids[0] = take_solid(message);
    solids[1] = take_solid(message);
  }
}

Outcome LibrarySession::take(const PosedQuestion& question) {
  if (!question.goes_on) forget();
  std::copy_n(question.placements, 2, placements_);
  for (const int side : {0, 1}) {
    if (made_[side] == nullptr) {
      const quoin_referee_solid view = question.solids[side].view();
      made_[side] = library_.make_solid(&view);
    }
    if (made_[side] == nullptr) return side == 0 ? Outcome::RefusedA : Outcome::RefusedB;
  }
  if (memory_ == nullptr && library_.make_memory != nullptr) memory_ = library_.make_memory();
  return Outcome::Answered;
}

void LibrarySession::forget() {
  for (void*& made : made_) {
    if (made != nullptr) library_.free_solid(made);
    made = nullptr;
  }
  if (memory_ != nullptr) library_.free_memory(memory_);
  memory_ = nullptr;
}

void LibrarySession::move() {
  library_.set_placement(made_[0], &placements_[0]);
  library_.set_placement(made_[1], &placements_[1]);
}

quoin_referee_status LibrarySession::ask(Memory memory, quoin_referee_answer& answer) {
  if (library_.ask == nullptr) return QUOIN_REFEREE_NO_ANSWER;
  return library_.ask(made_[0], made_[1], memory == Memory::Kept ? memory_ : nullptr, &answer);
}

double LibrarySession::seconds_of(Memory memory) {
  quoin_referee_answer answer{};
  const auto start = std::chrono::steady_clock::now();
  move();
  if (library_.ask != nullptr)
    ask(memory, answer);
  else
    list_points(memory);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

ListedPoints LibrarySession::list_points(Memory memory) {
  if (library_.list_points == nullptr) return {};
  room_.resize(kMostPoints);
  int count = kMostPoints;
  const quoin_referee_status status = library_.list_points(
      made_[0], made_[1], memory == Memory::Kept ? memory_ : nullptr, room_.data(), &count);
  if (status != QUOIN_REFEREE_ANSWERED) return {status, {}};
  if (count < 0 || count > kMostPoints) return {QUOIN_REFEREE_FAILED, {}};
  return {status, {room_.data(), static_cast<std::size_t>(count)}};
}

}  // namespace quoin::referee
