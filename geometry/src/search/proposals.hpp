#pragma once
/// Features and normals that may carry the answer, from what is cheap to ask: last step's features,
/// the faces that look at each other, the corners where a search ended. Internal.

#include "certify/candidate.hpp"
#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {

/// Last step's features first: if they carry the optimum still, and clearly, that is the answer.
bool hinted_plane(const Solid& p, const Solid& q, const FeatureHint& hint, const Lengths& length,
                  Optimum& optimum);

/// By how much the gap of a settled plane may miss the bound that the search proved, m.
double slack(double rounding, double gap);

/// The corners where the search ended; a face label that has all those of one solid stands for
/// them.
void take_corners(const Solid& p, const Solid& q, const SearchResult& found, ContactSets& sets);

/// The plane that the last corners of the search define: for short distances the search's own line
/// between vertices and edges has lost the digits that tell which vertices carry it.
bool settle_corners(const Solid& p, const Solid& q, const SearchResult& found,
                    const Lengths& length, CandidatePlane& plane);

/// The plane of two whole faces around the vertices that carry a plane, if it is theirs, proved to
/// be the answer, and they share a polygon surely wider than tol.
bool whole_faces(const Solid& p, const Solid& q, const Lengths& length, const Candidate& near,
                 Optimum& optimum);

/// The plane of all vertices that come near another one, if it is theirs alone and proved to be the
/// answer.
bool near_features(const Solid& p, const Solid& q, const Lengths& length, const Optimum& found,
                   Optimum& optimum);

/// The least gap that the search allows a plane to have, m.
double least_gap(const SearchResult& found, double rounding);

}  // namespace quoin::geometry
