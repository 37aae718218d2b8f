/// What messages and products cost between the processes of an mpirun, and how near the model of
/// exchange_model.hpp comes to an iteration of the same messages and products.
///
/// mpirun -n PARTS bench_exchange [COLUMNS ROWS]: messages between the first two processes; blocks
/// of 36 numbers in products of all processes at once; an iteration on the wall, modelled with
/// these and measured.

#include <mpi.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "exchange_model.hpp"

namespace {

using namespace quoin::bench;

constexpr int kRuns = 15;        // the quickest counts
constexpr int kIterations = 10;  // of each
constexpr int kLong = 1 << 15;   // bytes of a message, as long as those of 1e5 bricks

int rank_of_this() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

/// The same clock in all processes of a machine, which MPI_Wtime() need not be, s.
double now() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(since).count();
}

/// Quickest of some runs, s a call of `what`, from when the first process begins until the last one
/// ends.
template <class What>
double seconds(int runs, int calls, const What& what) {
  double quickest = 1e300;
  for (int run = 0; run < runs; ++run) {
    MPI_Barrier(MPI_COMM_WORLD);
    double span[2] = {-now(), 0.0}, all[2] = {};
    for (int call = 0; call < calls; ++call) what();
    span[1] = now();
    MPI_Allreduce(span, all, 2, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    quickest = std::min(quickest, (all[0] + all[1]) / calls);
  }
  return quickest;
}

/// Half of there and back between ranks 0 and 1, s.
double one_way(int bytes) {
  std::vector<char> data(static_cast<std::size_t>(bytes));
  const auto send = [&](int to) { MPI_Send(data.data(), bytes, MPI_CHAR, to, 0, MPI_COMM_WORLD); };
  const auto take = [&](int from) {
    MPI_Recv(data.data(), bytes, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  };
  const int rank = rank_of_this();
  return 0.5 * seconds(kRuns, bytes > 10000 ? 100 : 2000, [&] {
           if (rank == 0) send(1);
           if (rank < 2) take(1 - rank);
           if (rank == 1) send(0);
         });
}

/// Of many messages at once, s each on either side.
double of_burst() {
  constexpr int kMany = 64;
  std::vector<MPI_Request> requests(kMany);
  std::vector<double> data(kMany);
  const int rank = rank_of_this();
  const auto burst = [&] {
    for (int i = 0; i < kMany && rank < 2; ++i) {
      double* number = data.data() + i;
      MPI_Request* request = requests.data() + i;
      rank == 0 ? MPI_Isend(number, 1, MPI_DOUBLE, 1, i, MPI_COMM_WORLD, request)
                : MPI_Irecv(number, 1, MPI_DOUBLE, 0, i, MPI_COMM_WORLD, request);
    }
    if (rank < 2) MPI_Waitall(kMany, requests.data(), MPI_STATUSES_IGNORE);
  };
  return seconds(kRuns, 200, burst) / kMany;
}

/// Rows that this part reads and others read of it, by the part at the other end.
struct Exchange {
  std::map<int, std::vector<int>> sent, taken;
};

/// A product's rows of this part: places of what they read, own ones first and ghosts after them.
struct Product {
  Exchange exchange;
  std::vector<int> start{0}, place;
  std::vector<double> blocks, from, to;
};

Product product_of(const Graph& reads, const std::vector<int>& row_part,
                   const std::vector<int>& column_part, int part) {
  Product product;
  std::vector<int> place_of(column_part.size(), -1);
  int places = 0;
  for (std::size_t c = 0; c < column_part.size(); ++c) {
    if (column_part[c] == part) place_of[c] = places++;
  }
  for (const Ghost& ghost : ghosts_of(reads, row_part, column_part)) {
    const auto column = static_cast<std::size_t>(ghost.row);
    if (ghost.owner == part) product.exchange.sent[ghost.reader].push_back(place_of[column]);
    if (ghost.reader != part) continue;
    place_of[column] = places++;
    product.exchange.taken[ghost.owner].push_back(place_of[column]);
  }
  for (int row = 0; row < reads.rows(); ++row) {
    if (row_part[static_cast<std::size_t>(row)] != part) continue;
    for (const int* c = reads.begin(row); c != reads.end(row); ++c)
      product.place.push_back(place_of[static_cast<std::size_t>(*c)]);
    product.start.push_back(static_cast<int>(product.place.size()));
  }
  product.blocks.assign(36 * product.place.size(), 1e-3);
  product.from.assign(6 * static_cast<std::size_t>(places), 1.0);
  product.to.assign(6 * (product.start.size() - 1), 0.0);
  return product;
}

void multiply(Product& product) {
  using Vector = Eigen::Map<Eigen::Matrix<double, 6, 1>>;
  for (std::size_t row = 0; row + 1 < product.start.size(); ++row) {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (int k = product.start[row]; k < product.start[row + 1]; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Eigen::Map<const Eigen::Matrix<double, 6, 6>> block(product.blocks.data() + 36 * i);
      sum += block * Vector(product.from.data() + 6 * product.place[i]);
    }
    Vector(product.to.data() + 6 * row) = sum;
  }
}

/// One part of an iteration; without messages where it is alone.
class Iteration {
 public:
  Iteration(std::span<const Level> levels, int part) {
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const std::vector<int>& rows = levels[l].part_of;
      matrices_.push_back(product_of(levels[l].matrix, rows, rows, part));
      if (l + 1 == levels.size()) break;
      transfers_.push_back(product_of(levels[l].prolongation, rows, levels[l + 1].part_of, part));
    }
  }

  void product(int level) { told(matrices_[static_cast<std::size_t>(level)]); }
  void prolong_to(int level) { told(transfers_[static_cast<std::size_t>(level)]); }
  void restrict_from(int level) {
    Product& transfer = transfers_[static_cast<std::size_t>(level)];
    multiply(transfer);
    begin(transfer, transfer.exchange.taken, transfer.exchange.sent);
    end();
  }
  void solve_last() { multiply(matrices_.back()); }
  void sum(int numbers) {
    if (alone) return;
    std::vector<double> mine(static_cast<std::size_t>(numbers), 1.0), all(mine);
    MPI_Allreduce(mine.data(), all.data(), numbers, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  }

  bool alone = false;

 private:
  using Rows = std::map<int, std::vector<int>>;

  void told(Product& product) {
    begin(product, product.exchange.sent, product.exchange.taken);
    multiply(product);
    end();
  }

  void begin(Product& product, const Rows& sent, const Rows& taken) {
    if (alone) return;
    for (const auto& [part, rows] : taken) {
      std::vector<double>& data = memory(rows.size());
      MPI_Irecv(data.data(), static_cast<int>(data.size()), MPI_DOUBLE, part, 0, MPI_COMM_WORLD,
                &requests_.emplace_back());
    }
    for (const auto& [part, rows] : sent) {
      std::vector<double>& data = memory(rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i)
        std::copy_n(product.from.data() + 6 * rows[i], 6, data.data() + 6 * i);
      MPI_Isend(data.data(), static_cast<int>(data.size()), MPI_DOUBLE, part, 0, MPI_COMM_WORLD,
                &requests_.emplace_back());
    }
  }

  void end() {
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    requests_.clear();
    used_ = 0;
  }

  std::vector<double>& memory(std::size_t rows) {
    if (used_ == memory_.size()) memory_.emplace_back();
    memory_[used_].resize(6 * rows);
    return memory_[used_++];
  }

  std::vector<Product> matrices_, transfers_;
  std::vector<MPI_Request> requests_;
  std::vector<std::vector<double>> memory_;
  std::size_t used_ = 0;
};

/// Blocks that are multiplied one after the other in an iteration: of each phase by the part that
/// has most.
long most_blocks(std::span<const LevelWork> work, int parts) {
  IterationCost one = simulate(work, parts, {.coupling = 1.0});
  return static_cast<long>(one.time);
}

void compare(int columns, int rows, int parts, int part) {
  const std::vector<Level> levels = wall_levels(columns, rows, parts);
  const std::vector<LevelWork> work = work_of(levels, parts);
  Iteration iteration(levels, part);
  const int last = static_cast<int>(levels.size()) - 1;
  const auto iterated = [&] { iterate(last, iteration); };
  Machine machine;
  double alone = 1e300, measured = 1e300;
  for (int run = 0; run < kRuns; ++run) {
    iteration.alone = true;
    alone = std::min(alone, seconds(kIterations, 1, iterated));
    iteration.alone = false;
    measured = std::min(measured, seconds(kIterations, 1, iterated));
  }
  machine.coupling = alone / static_cast<double>(most_blocks(work, parts));
  if (parts > 1) {
    machine.latency = one_way(8);
    machine.message = std::min(of_burst(), 0.5 * machine.latency);
    machine.byte = (one_way(kLong) - machine.latency) / kLong;
  }
  const IterationCost model = simulate(work, parts, machine);
  if (part != 0) return;
  std::printf("%d parts, %d bricks, levels", parts, levels[0].matrix.rows());
  for (const Level& level : levels) std::printf(" %d", level.matrix.rows());
  std::printf(
      "\nlatency %.3g us, message %.3g us, byte %.3g ns, block %.3g ns\n"
      "an iteration: measured %.4g us, modelled %.4g: arithmetic %.4g, messages %.3g, waiting "
      "%.3g; %.1f messages sent in %d exchanges\n",
      1e6 * machine.latency, 1e6 * machine.message, 1e9 * machine.byte, 1e9 * machine.coupling,
      1e6 * measured, 1e6 * model.time, 1e6 * model.arithmetic, 1e6 * model.messages,
      1e6 * model.waiting, model.sent, model.exchanges);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int parts = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &parts);
  const int columns = argc > 2 ? std::atoi(argv[1]) : 125,
            rows = argc > 2 ? std::atoi(argv[2]) : 80;
  compare(columns, rows, parts, rank_of_this());
  MPI_Finalize();
}
