#include "search/nearest_features.hpp"

#include <limits>

#include "certify/canonical_order.hpp"
#include "numeric/numbers.hpp"
#include "search/proposals.hpp"
#include "search/quick_answers.hpp"

namespace quoin::geometry {
namespace {

struct Question {
  const Solid &a, &b;
  const SearchOptions& options;
  const FeatureHint& hint;
  Lengths length;
  LateInit<ContactPolygon>* faces;  // null: nobody asks for what they share
};

/// The general way; true: an ordinary answer after all, in the names of the caller.
bool general_answer(const CanonicalPair& pair, const Question& question, Quick& quick,
                    Optimum& optimum, NearestFeatures& answer) {
  const Solid &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  FeatureHint hint = question.hint;
  if (pair.reversed) swap_names(hint);
  const auto warm = [&] {
    return quick.hint == Trial::Undecided && hinted_plane(p, q, hint, length, optimum);
  };
  if (length.uneven || !warm()) {
    if (!length.uneven && !quick.searched &&
        searched_answer(pair.a(), pair.b(), length, question.hint, quick, answer))
      return true;
    if (length.uneven || !fast_answer(pair, quick, optimum)) {
      optimum.faces.reset();
      exact_answer(pair, question.options.max_iterations, quick.found, optimum);
    }
  }
  describe_best(pair, optimum, answer);
  return false;
}

/// Whatever the quick ways have left open; not inline, for its room on the stack is of no use to
/// them.
[[gnu::noinline]] void find_at_last(const Question& question, Quick& quick,
                                    NearestFeatures& answer) {
  const CanonicalPair pair = ordered(question.a, question.b, question.length);
  LateInit<ContactPolygon> own;
  Optimum optimum(question.faces != nullptr ? *question.faces : own);
  const bool ordinary = general_answer(pair, question, quick, optimum, answer);
  if (pair.reversed && !ordinary) swap_names(answer);
  answer.iterations = quick.iterations + optimum.iterations;
}

/// Where the hint, or without one the features around two corners, have not led to the answer.
[[gnu::noinline]] void find_by_search(const Question& question, Trial trial,
                                      NearestFeatures& answer) {
  const auto& [a, b, options, hint, length, faces] = question;
  if (!(b.vertex_mean() - a.vertex_mean()).allFinite()) {  // a placement that is none
    answer.status = PairStatus::NotConverged;
    answer.gap = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  Quick quick{.hint = trial, .iterations = answer.iterations, .faces = faces};
  const bool hint_left = trial == Trial::Undecided && hint.vertices_a[0] >= 0;
  if (!length.uneven && !hint_left && searched_answer(a, b, length, hint, quick, answer)) {
    answer.iterations = quick.iterations;
    return;
  }
  find_at_last(question, quick, answer);
}

/// Built into each entrance: a warm query is a few hundred instructions.
[[gnu::always_inline]] inline void find(const Solid& a, const Solid& b,
                                        const SearchOptions& options, const FeatureHint& hint,
                                        LateInit<ContactPolygon>* faces, NearestFeatures& answer) {
  const Lengths length = lengths(a, b, options.tolerance);
  Trial trial = Trial::Undecided;
  const auto at_once = [&] {
    return hint.vertices_a[0] < 0 ? corner_answer(a, b, length, answer.iterations, answer)
                                  : hinted_answer(a, b, length, hint, trial, answer);
  };
  if (length.uneven || !at_once())
    find_by_search({a, b, options, hint, length, faces}, trial, answer);
}

}  // namespace

void find_nearest_features(const Solid& a, const Solid& b, const SearchOptions& options,
                           const FeatureHint& hint, LateInit<ContactPolygon>* faces,
                           NearestFeatures& answer) {
  find(a, b, options, hint, faces, answer);
}

NearestFeatures nearest_features(const Body& a, const Body& b, const SearchOptions& options,
                                 const FeatureHint& hint) {
  require_length(options.tolerance, "tolerance");
  const PlacedPair pair(a, b);
  NearestFeatures answer;
  find(pair.a, pair.b, options, hint, nullptr, answer);
  move(pair, answer);
  return answer;
}

}  // namespace quoin::geometry
