/// The plug-ins of `quoin referee` as peers: the same code is judged there and timed here.

#include <dlfcn.h>
#include <quoin/referee.h>

#include <numeric>
#include <stdexcept>

#include "peer.hpp"

namespace quoin::bench {
namespace {

using Library = quoin_referee_library;

/// Of all plug-ins that were built, which stay loaded.
std::vector<const Library*> libraries() {
  std::vector<const Library*> found;
  for (const char* file : {QUOIN_BENCH_PLUGINS}) {
    void* plugin = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (plugin == nullptr) throw std::runtime_error(dlerror());
    const auto entry =
        reinterpret_cast<decltype(&quoin_referee_plugin)>(dlsym(plugin, "quoin_referee_plugin"));
    for (int i = 0; const Library* library = entry(i); ++i) found.push_back(library);
  }
  return found;
}

/// Two solids a pair, as the library holds them.
class Solids {
 public:
  explicit Solids(const Library& library) : library_(library) {}
  Solids(const Solids&) = delete;
  Solids& operator=(const Solids&) = delete;
  ~Solids() { clear(); }

  bool can_be(const Workload& workload) const {
    return (library_.offers & QUOIN_REFEREE_BOXES_ONLY) == 0 || workload.boxes_only();
  }
  void load(const Workload& workload) {
    clear();
    workload_ = &workload;
    for (const Pair& pair : workload.pairs) {
      solids_.push_back(made(workload.shapes[static_cast<std::size_t>(pair.shape_a)]));
      solids_.push_back(made(workload.shapes[static_cast<std::size_t>(pair.shape_b)]));
    }
    place(0);
  }
  void place(int step) {
    const auto s = static_cast<std::size_t>(step);
    for (std::size_t k = 0; k < workload_->pairs.size(); ++k) {
      put(solids_[2 * k], workload_->pairs[k].poses_a[s]);
      put(solids_[2 * k + 1], workload_->pairs[k].poses_b[s]);
    }
  }
  void* a(int pair) const { return solids_[2 * static_cast<std::size_t>(pair)]; }
  void* b(int pair) const { return solids_[2 * static_cast<std::size_t>(pair) + 1]; }

 private:
  void* made(const BenchShape& shape) const {
    std::vector<int> sizes, corners;
    for (int f = 0; f < shape.topology->face_count(); ++f) {
      const auto face = shape.topology->face(f);
      sizes.push_back(static_cast<int>(face.size()));
      corners.insert(corners.end(), face.begin(), face.end());
    }
    quoin_referee_solid solid{shape.vertices.data(),
                              static_cast<int>(shape.vertices.cols()),
                              sizes.data(),
                              static_cast<int>(sizes.size()),
                              corners.data(),
                              {},
                              {}};
    if (shape.is_box) std::copy_n(shape.half_size.data(), 3, solid.box_half);
    void* peer = library_.make_solid(&solid);
    if (peer == nullptr)
      throw std::runtime_error(std::string(library_.name) + " takes no such solid");
    return peer;
  }
  void put(void* solid, const Pose& pose) const {
    quoin_referee_placement to{};
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(to.linear) = pose.rotation;
    std::copy_n(pose.place.data(), 3, to.translation);
    library_.set_placement(solid, &to);
  }
  void clear() {
    for (void* solid : solids_) library_.free_solid(solid);
    solids_.clear();
  }

  const Library& library_;
  const Workload* workload_ = nullptr;
  std::vector<void*> solids_;
};

class PluginPeer final : public PeerOf<PluginPeer> {
 public:
  PluginPeer(const Library& library, bool warm)
      : PeerOf(std::string(library.name) + (warm ? " warm" : "")),
        library_(library),
        warm_(warm),
        solids_(library) {}
  ~PluginPeer() override { drop(); }
  bool answers(const Workload& workload) const override {
    const int offer = workload.overlap ? QUOIN_REFEREE_DEPTH : QUOIN_REFEREE_DISTANCE;
    return (library_.offers & offer) != 0 && solids_.can_be(workload) && (!warm_ || workload.warm);
  }
  void load(const Workload& workload) override {
    solids_.load(workload);
    drop();
    memories_.resize(workload.pairs.size());
    forget();
  }
  void place(int step) override { solids_.place(step); }
  void forget() override {
    if (!warm_) return;
    for (void*& memory : memories_) {
      if (memory != nullptr) library_.free_memory(memory);
      memory = library_.make_memory();
    }
  }
  Answer query(int pair) {
    quoin_referee_answer found{};
    const quoin_referee_status status = library_.ask(
        solids_.a(pair), solids_.b(pair), memories_[static_cast<std::size_t>(pair)], &found);
    if (status == QUOIN_REFEREE_FAILED) return {std::numeric_limits<double>::quiet_NaN()};
    return {found.gap, Vector3(found.normal), Vector3(found.point_a), Vector3(found.point_b)};
  }

 private:
  void drop() {
    for (void* memory : memories_)
      if (memory != nullptr) library_.free_memory(memory);
    memories_.clear();
  }

  const Library& library_;
  bool warm_;
  Solids solids_;
  std::vector<void*> memories_;  // null: none
};

class PluginManifold final : public ManifoldPeer {
 public:
  explicit PluginManifold(const Library& library)
      : ManifoldPeer(library.name), library_(library), solids_(library), points_(kRoom) {}
  bool answers(const Workload& workload) const override {
    return (workload.overlap || (library_.offers & QUOIN_REFEREE_APART) != 0) &&
           solids_.can_be(workload);
  }
  void load(const Workload& workload) override { solids_.load(workload); }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    points.clear();
    for (int i = 0, count = find(pair); i < count; ++i) {
      const quoin_referee_point& p = points_[static_cast<std::size_t>(i)];
      points.push_back({0.5 * (Vector3(p.point_a) + Vector3(p.point_b)), p.gap});
    }
  }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) sum += find(pair) > 0 ? points_[0].gap : 0.0;
    return sum;
  }

 private:
  static constexpr std::size_t kRoom = 4096;  // of the interface
  int find(int pair) {
    int count = kRoom;
    library_.list_points(solids_.a(pair), solids_.b(pair), nullptr, points_.data(), &count);
    return count;
  }
  const Library& library_;
  Solids solids_;
  std::vector<quoin_referee_point> points_;
};

}  // namespace

void count_queries(AnyPeer& peer, const std::string& name, const Workload& workload) {
  peer.load(workload);
  std::vector<int> pairs(workload.pairs.size());
  std::iota(pairs.begin(), pairs.end(), 0);
  start_callgrind();
  for (int step = 0; step < workload.steps; ++step) {
    peer.place(step);
    if (step == 0) benchmark::DoNotOptimize(peer.ask_all(pairs));
    counted([&] { benchmark::DoNotOptimize(peer.ask_all(pairs)); });
  }
  print_counted(name, peer.name(), pairs.size() * static_cast<std::size_t>(workload.steps));
}

void append_plugins(Peers& peers) {
  for (const Library* library : libraries()) {
    if (library->ask == nullptr) continue;
    peers.push_back(std::make_unique<PluginPeer>(*library, false));
    if (library->make_memory != nullptr)
      peers.push_back(std::make_unique<PluginPeer>(*library, true));
  }
}

void append_plugins(ManifoldPeers& peers) {
  for (const Library* library : libraries())
    if (library->list_points != nullptr)
      peers.push_back(std::make_unique<PluginManifold>(*library));
}

}  // namespace quoin::bench
