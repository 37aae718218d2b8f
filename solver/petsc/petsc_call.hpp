#pragma once
/// PETSc's error codes as exceptions, its objects with an end.

#include <petscsys.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace quoin::solver {

/// Throws std::runtime_error with PETSc's message for a code that is none of success.
inline void petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* general = nullptr;
  char* special = nullptr;
  PetscErrorMessage(static_cast<int>(code), &general, &special);
  std::string message = "PETSc: ";
  message += general != nullptr ? general : "an error without a name";
  if (special != nullptr && *special != '\0') message += ": " + std::string(special);
  throw std::runtime_error(message);
}

/// Mat, Vec, KSP, VecScatter: destroyed by all ranks together.
template <typename Object, PetscErrorCode (*destroy)(Object*)>
class Petsc {
 public:
  Petsc() = default;
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;
  ~Petsc() { reset(); }
  void reset() {
    if (object_ != nullptr) destroy(&object_);
    object_ = nullptr;
  }
  Object get() const { return object_; }
  /// For functions that make one; what was there is destroyed.
  Object* fresh() {
    reset();
    return &object_;
  }

 private:
  Object object_ = nullptr;
};

}  // namespace quoin::solver
