#include "referee.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>

#include "race.hpp"
#include "referee/pairs/families.hpp"
#include "referee/pairs/pair_text.hpp"
#include "shrink.hpp"

namespace quoin::referee {
namespace {

using Clock = std::chrono::steady_clock;

/// From one step to the next a solid moves by at most this part of its size, and so many radians:
/// two bodies at 1 m/s in steps of 1 ms.
constexpr double kStepAmount = 1e-3;
/// Times of a library on a family: no median needs more.
constexpr std::size_t kMostTimes = 200;

bool shows(const Judgement& judgement, const std::string& kind) {
  const std::vector<Fault>& faults = judgement.faults.list;
  return std::any_of(faults.begin(), faults.end(),
                     [&](const Fault& fault) { return fault.kind == kind; });
}

/// None where a solid lies in one plane.
std::optional<Judge> judge_of(const Question& question) {
  try {
    return std::optional<Judge>(std::in_place, question);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

class Run {
 public:
  explicit Run(const Options& options) : options_(options) {
    for (const std::string& file : options.plugins) {
      for (LibraryInfo& library : libraries_of(file)) {
        library.name = unused_name(library.name);
        report_.libraries.push_back(library);
        plugins_.push_back(std::make_unique<Plugin>(library, options.limit));
      }
    }
    race_.emplace(report_.libraries, options.limit);
    report_.seed = options.seed;
  }

  Report run() {
    const Clock::time_point start = Clock::now();
    const long count =
        options_.pairs.empty() ? options_.count : static_cast<long>(options_.pairs.size());
    for (long number = 0; number < count && !over(); ++number) {
      ask_sequence(number);
      if (options_.progress && number % 100 == 99) options_.progress(report_.questions);
    }
    report_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return std::move(report_);
  }

 private:
  /// Two builds of one library may stand beside each other.
  std::string unused_name(const std::string& name) const {
    std::string candidate = name;
    for (int number = 2; std::any_of(report_.libraries.begin(), report_.libraries.end(),
                                     [&](const LibraryInfo& l) { return l.name == candidate; });
         ++number)
      candidate = name + " (" + std::to_string(number) + ")";
    return candidate;
  }

  bool over() const { return options_.stop && options_.stop(); }

  SolidPair draw(long number, Random& random) const {
    if (!options_.pairs.empty()) return options_.pairs[static_cast<std::size_t>(number)];
    return make_pair(random, options_.families);
  }

  void ask_sequence(long number) {
    Random random(options_.seed * 1000003 + static_cast<std::uint64_t>(number));
    Question question(draw(number, random));
    const SteadyMotion motion(question.pair.b, kStepAmount, random);
    for (int step = 0; step < options_.steps && !over(); ++step) {
      if (step > 0) question.pair.b.placed.placement = motion.at(step);
      ask_all(question);
    }
  }

  void ask_all(const Question& question) {
    const std::optional<Judge> judge = judge_of(question);
    if (!judge) {
      ++report_.left_out;
      return;
    }
    ++report_.questions;
    std::vector<bool> timed;
    for (const auto& plugin : plugins_) {
      timed.push_back(judge->offered(plugin->info()) && ask(*plugin, *judge, question) &&
                      tally_of(*plugin, question).seconds.size() < kMostTimes);
    }
    time(question, timed);
  }

  /// Those that answered without harm.
  void time(const Question& question, const std::vector<bool>& timed) {
    if (std::find(timed.begin(), timed.end(), true) == timed.end()) return;
    const std::vector<std::optional<double>> seconds = race_->seconds(question, timed);
    for (std::size_t i = 0; i < plugins_.size(); ++i)
      if (seconds[i]) tally_of(*plugins_[i], question).seconds.push_back(*seconds[i]);
  }

  Tally& tally_of(const Plugin& plugin, const Question& question) {
    return report_.tallies[plugin.info().name][question.pair.family];
  }

  /// Whether it answered.
  bool ask(Plugin& plugin, const Judge& judge, const Question& question) {
    const Answer answer = plugin.ask(question);
    const Judgement judgement = judge.judge(plugin.info(), answer);
    Tally& tally = tally_of(plugin, question);
    count(judgement, tally);
    for (const Fault& fault : judgement.faults.list)
      if (tally.kinds[fault.kind] == 1)  // the first of its kind
        keep(plugin, question.pair, fault);
    return judgement.answered;
  }

  void keep(Plugin& plugin, const SolidPair& pair, const Fault& fault) {
    const auto fails = [&](const SolidPair& changed) {
      if (over()) return false;
      const Question question(changed);
      const std::optional<Judge> judge = judge_of(question);
      return judge && judge->offered(plugin.info()) &&
             shows(judge->judge(plugin.info(), plugin.ask(question)), fault.kind);
    };
    const bool slow = fault.kind == "hang";  // every question takes the whole time limit
    const SolidPair small = slow ? pair : shrink(pair, fails, options_.shrink_questions);
    const std::string& library = plugin.info().name;
    report_.failures.push_back({library, pair.family, fault.kind, fault.text,
                                pair_as_json(small, library + " " + fault.kind), pair_as_cpp(small),
                                pair_as_c(small)});
  }

  const Options& options_;
  Report report_;
  std::vector<std::unique_ptr<Plugin>> plugins_;
  std::optional<Race> race_;
};

}  // namespace

Report run(const Options& options) { return Run(options).run(); }

}  // namespace quoin::referee
