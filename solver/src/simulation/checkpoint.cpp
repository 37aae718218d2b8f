#include "simulation/checkpoint.hpp"

#include <algorithm>
#include <cstdint>
#include <istream>
#include <ostream>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>

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
    if (!in_.read(static_cast<char*>(to), static_cast<std::streamsize>(count)))
      throw InputError("the checkpoint is cut short");
  }
  std::size_t count(std::size_t /*now*/) {
    std::size_t n = 0;
    bytes(&n, sizeof n);
    return n;
  }

 private:
  std::istream& in_;
};

/// A plain record without pointers. What lies between its fields is written as zeros, if the
/// compiler can: equal states are equal bytes.
template <class Archive, class Value>
void record(Archive& archive, Value& value) {
  static_assert(std::is_trivially_destructible_v<std::remove_const_t<Value>>);
  if constexpr (std::is_const_v<Value>) {
    auto copy = value;
#if __has_builtin(__builtin_clear_padding)
    __builtin_clear_padding(&copy);
#endif
    archive.bytes(&copy, sizeof copy);
  } else {
    archive.bytes(&value, sizeof value);
  }
}

template <class Archive, class List>
void list(Archive& archive, List& values) {
  const std::size_t count = archive.count(values.size());
  if constexpr (!std::is_const_v<List>) values.resize(count);
  for (auto& value : values) record(archive, value);
}

/// FNV-1a [Fowler, Noll & Vo], 64 bits.
class Digest {
 public:
  void add(const void* from, std::size_t count) {
    const auto* bytes = static_cast<const unsigned char*>(from);
    for (std::size_t i = 0; i < count; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3;
  }
  void add(double value) { add(&value, sizeof value); }
  template <class Derived>
  void add(const Eigen::PlainObjectBase<Derived>& values) {
    add(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/// What stands before the bytes of a checkpoint.
struct Seal {
  std::size_t size = 0;
  std::uint64_t digest = 0;
};

Seal seal_of(const std::string& bytes) {
  Digest digest;
  digest.add(bytes.data(), bytes.size());
  return {bytes.size(), digest.value()};
}

/// The bytes behind a seal. A damaged one may name any size: memory is taken for what is there.
std::string unsealed(std::istream& in) {
  constexpr std::size_t kPart = std::size_t{1} << 20;
  Reader reader(in);
  Seal seal;
  record(reader, seal);
  std::string bytes;
  while (bytes.size() < seal.size) {
    const std::size_t had = bytes.size();
    bytes.resize(had + std::min(kPart, seal.size - had));
    reader.bytes(bytes.data() + had, bytes.size() - had);
  }
  if (seal_of(bytes).digest != seal.digest) throw InputError("the checkpoint is damaged");
  return bytes;
}

/// What tells the blocks of one scene and one build from another's.
struct Stamp {
  std::size_t blocks = 0, vertices = 0;
  std::uint64_t digest = 0;
  std::size_t sizes[5] = {sizeof(BlockState), sizeof(Contact), sizeof(geometry::ContactPoint),
                          sizeof(StepReport), sizeof(PrescribedMotion)};
  bool operator==(const Stamp&) const = default;
};

Stamp stamp(const CompiledScene& compiled) {
  Stamp result{.blocks = compiled.scene.blocks.size()};
  Digest digest;
  for (const Block& block : compiled.scene.blocks) {
    result.vertices += static_cast<std::size_t>(block.shape->vertex_count());
    digest.add(block.shape->vertices());
    digest.add(block.placement.linear);
    digest.add(block.placement.translation);
    digest.add(static_cast<double>(block.kind));
    for (const double of : {block.material.density, block.material.young, block.material.poisson})
      digest.add(of);
  }
  result.digest = digest.value();
  return result;
}

/// Have the lists as many items as the scene has blocks, and contacts two of these?
bool fits(const CompiledScene& compiled, const State& state, const Workspace& work) {
  const std::size_t blocks = compiled.models.size(), slots = compiled.slots.size.size();
  const auto are = [](std::size_t count, auto... sizes) { return ((sizes == count) && ...); };
  const auto exists = [&](int block) { return block >= 0 && block < static_cast<int>(blocks); };
  const auto has_blocks = [&](const geometry::ContactKey& key) {
    return exists(key.a) && exists(key.b);
  };
  return are(blocks, state.blocks.size(), work.energy_scale.size(), work.laid.size(),
             work.at_rest.size(), work.last.hit.size(), work.last.crowded.size()) &&
         are(slots, work.last.length.size(), work.last.velocity.size()) &&
         state.held_forces.size() == compiled.held.size() &&
         state.ties.size() == compiled.ties.size() &&
         state.quiet_forces.size() == compiled.quiet.size() &&
         work.motion.size() == compiled.prescribed.size() &&
         std::ranges::all_of(state.contacts,
                             [&](const Contact& c) { return has_blocks(c.point.key); }) &&
         std::ranges::all_of(work.found, [&](const auto& point) { return has_blocks(point.key); });
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
  list(archive, state.ties);
  list(archive, state.quiet_forces);
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
  for (auto& held : compiled.held) {
    record(archive, held.from);
    record(archive, held.since);
  }
  list(archive, work.initial_depths.entries);
  list(archive, work.waiting);
}

}  // namespace

void write_checkpoint(std::ostream& out, const CompiledScene& compiled, const State& state,
                      const Workspace& work) {
  std::ostringstream made;
  Writer writer(made);
  const Stamp now = stamp(compiled);
  record(writer, now);
  transfer(writer, state, work);
  transfer_setting(writer, compiled, work);
  const std::string bytes = std::move(made).str();
  const Seal seal = seal_of(bytes);
  Writer sealed(out);
  record(sealed, seal);
  sealed.bytes(bytes.data(), bytes.size());
}

void read_checkpoint(std::istream& in, CompiledScene& compiled, State& state, Workspace& work) {
  std::istringstream bytes(unsealed(in));
  Reader reader(bytes);
  Stamp saved;
  record(reader, saved);
  const char* other = "the checkpoint is of another scene or program";
  if (saved != stamp(compiled)) throw InputError(other);
  transfer(reader, state, work);
  if (!fits(compiled, state, work)) throw InputError(other);
  transfer_setting(reader, compiled, work);
}

}  // namespace quoin::solver
