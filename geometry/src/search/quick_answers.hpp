#pragma once
/// The quick ways to an answer: each proposes features and proves them at once. Internal.

#include <optional>

#include "certify/candidate.hpp"
#include "certify/canonical_order.hpp"
#include "search/corner_features.hpp"
#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {

/// The quick ways, and what is known when they have not come to the answer. For solids apart they
/// work in the order of the caller: turned round, each of their steps is the same but for signs.
struct Quick {
  Trial hint = Trial::Undecided;  // what became of last step's features
  bool searched = false;
  SearchResult found = {};             // if `searched`: in the order in which the pair is worked
  bool grown = false;                  // `found` is the least overlap
  std::optional<Vector3> middle = {};  // of several planes that part the solids within rounding
  std::optional<Vector3> facing = {};  // of the faces that part two bricks most
  int iterations = 0;
  LateInit<ContactPolygon>* faces = nullptr;  // null: nobody asks for what two faces share
};

/// Last step's features as an ordinary answer.
inline bool hinted_answer(const Solid& a, const Solid& b, const Lengths& length,
                          const FeatureHint& hint, Trial& trial, NearestFeatures& answer) {
  trial = certify_hint(a, b, hint, length, answer);
  answer.iterations = trial == Trial::Undecided ? 0 : 1;
  return trial == Trial::Proved;
}

/// The features around two corners as an ordinary answer.
inline bool corner_answer(const Solid& a, const Solid& b, const Lengths& length, int& iterations,
                          NearestFeatures& answer) {
  if (!has_plain_corners(a, b)) return false;
  ++iterations;
  return certify_corners(a, b, length, answer) == Trial::Proved;
}

/// The answer of a search that starts cold. Without a hint the features around two corners have
/// been tried.
bool searched_answer(const Solid& a, const Solid& b, const Lengths& length, const FeatureHint& hint,
                     Quick& quick, NearestFeatures& answer);

/// The plane that carries the answer, from where the searches have come to.
bool fast_answer(const CanonicalPair& pair, const Quick& quick, Optimum& optimum);

/// The answer in full. Where rounding has led to a plane that is not straight, two whole faces that
/// clearly carry theirs come first, then all vertices near it: of a bumpy face, or a face along
/// which an edge lies, some corners alone carry another plane that is as good.
void describe_best(const CanonicalPair& pair, Optimum& optimum, NearestFeatures& answer);

/// In double-double. `known`: where the search in doubles has come to.
void exact_answer(const CanonicalPair& pair, int max_iterations, const SearchResult& known,
                  Optimum& optimum);

/// Fills all of an answer but the number of iterations, in the names of P and Q.
void describe(const Solid& p, const Solid& q, Optimum& optimum, const Lengths& length,
              NearestFeatures& answer);

}  // namespace quoin::geometry
