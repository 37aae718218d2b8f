#include "checkpoint.hpp"

#include <istream>
#include <ostream>
#include <type_traits>

namespace quoin::solver {
namespace {

/// Writes fields, or reads them into the same places: one list of fields serves both ways.
class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}

  void bytes(const void* from, std::size_t count) {
    out_.write(static_cast<const char*>(from), static_cast<std::streamsize>(count));
  }
  std::size_t count(std::size_t n) {
    bytes(&n, sizeof n);
    return n;
  }

 private:
  std::ostream& out_;
};

class Reader {
 public:
  explicit Reader(std::istream& in) : in_(in) {}

  void bytes(void* to, std::size_t count) {
    if (!in_.read(static_cast<char*>(to), static_cast<std::streamsize>(count))) {
      throw InputError("the checkpoint is cut short");
    }
  }
  std::size_t count(std::size_t /*now*/) {
    std::size_t n = 0;
    bytes(&n, sizeof n);
    if (n > kMost) throw InputError("the checkpoint is damaged");
    return n;
  }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 32;  // items of a list: more is no list
  std::istream& in_;
};

/// A plain record without pointers.
template <class Archive, class Value>
void record(Archive& archive, Value& value) {
  static_assert(std::is_trivially_destructible_v<std::remove_const_t<Value>>);
  archive.bytes(&value, sizeof value);
}

template <class Archive, class List>
void list(Archive& archive, List& values) {
  using Value = typename std::remove_const_t<List>::value_type;
  static_assert(std::is_trivially_destructible_v<Value>);
  const std::size_t count = archive.count(values.size());
  if constexpr (!std::is_const_v<List>) values.resize(count);
  archive.bytes(values.data(), count * sizeof(Value));
}

/// What tells one scene and one build from another.
struct Stamp {
  std::size_t blocks = 0, vertices = 0;
  std::size_t sizes[5] = {sizeof(BlockState), sizeof(Contact), sizeof(geometry::ContactPoint),
                          sizeof(StepReport), sizeof(PrescribedMotion)};
  bool operator==(const Stamp&) const = default;
};

Stamp stamp(const Workspace& work) {
  Stamp result{.blocks = static_cast<std::size_t>(work.finder.size())};
  for (int b = 0; b < work.finder.size(); ++b) {
    result.vertices += static_cast<std::size_t>(work.finder.body(b).shape().vertex_count());
  }
  return result;
}

template <class Archive, class AnyState, class AnyWorkspace>
void transfer(Archive& archive, AnyState& state, AnyWorkspace& work) {
  record(archive, state.time);
  record(archive, state.step);
  record(archive, state.origin);
  record(archive, state.energy);
  list(archive, state.blocks);
  list(archive, state.contacts);
  list(archive, state.held_forces);
  record(archive, work.still);
  record(archive, work.report);
  record(archive, work.counted);
  record(archive, work.search.pseudo_step);
  record(archive, work.search.longest);
  record(archive, work.search.unbalance);
  list(archive, work.search.start);
  list(archive, work.energy_scale);
  list(archive, work.last.length);
  list(archive, work.laid);
  list(archive, work.at_rest);
  list(archive, work.found);
  list(archive, work.motion);
  list(archive, work.last.velocity);
  list(archive, work.last.hit);
  list(archive, work.last.crowded);
  list(archive, work.stored);
}

/// What else the steps depend on: it changes from one scene to the next, never in a step.
template <class Archive, class AnyScene, class AnyWorkspace>
void transfer_setting(Archive& archive, AnyScene& compiled, AnyWorkspace& work) {
  for (auto& held : compiled.held) record(archive, held.from);
  list(archive, work.initial_depths.entries);
}

}  // namespace

void write_setting(std::ostream& out, const CompiledScene& compiled, const Workspace& work) {
  Writer writer(out);
  transfer_setting(writer, compiled, work);
}

void read_setting(std::istream& in, CompiledScene& compiled, Workspace& work) {
  Reader reader(in);
  transfer_setting(reader, compiled, work);
}

void write_checkpoint(std::ostream& out, const State& state, const Workspace& work) {
  Writer writer(out);
  const Stamp now = stamp(work);
  record(writer, now);
  transfer(writer, state, work);
}

void read_checkpoint(std::istream& in, State& state, Workspace& work) {
  Reader reader(in);
  Stamp saved;
  record(reader, saved);
  if (saved != stamp(work)) throw InputError("the checkpoint is of another scene or program");
  transfer(reader, state, work);
}

}  // namespace quoin::solver
