// The Python module quoin._quoin.
#include "arrays.hpp"
#include "scene_file/mesh_file.hpp"
#include "scene_file/scene_error.hpp"

namespace {

void translate(const std::exception& error, const char* type) {
  const auto module = pybind11::module_::import("quoin._quoin");
  PyErr_SetString(module.attr(type).ptr(), error.what());
}

/// T.__new__(T) would make an object without a value of C++ behind it, which pybind11 does not see.
void refuse_new(pybind11::module_& module) {
  const pybind11::cpp_function refuse(
      [](const pybind11::args&, const pybind11::kwargs&) -> pybind11::object {
        throw pybind11::type_error("objects of quoin are made by calling their class");
      });
  for (const auto& [name, value] : module.attr("__dict__").cast<pybind11::dict>()) {
    if (PyType_Check(value.ptr()) == 0 || PyExceptionClass_Check(value.ptr()) != 0) continue;
    auto* type = reinterpret_cast<PyTypeObject*>(value.ptr());
    PyDict_SetItemString(type->tp_dict, "__new__", refuse.ptr());  // the slot stays
    PyType_Modified(type);
  }
}

}  // namespace

PYBIND11_MODULE(_quoin, module) {
  namespace python = quoin::python;
  module.attr("__version__") = QUOIN_VERSION;
  pybind11::register_exception<quoin::geometry::InputError>(module, "InputError", PyExc_ValueError);
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const quoin::scene_file::SceneError& error) {
      translate(error, "InputError");
    } catch (const quoin::scene_file::MeshError& error) {
      translate(error, "InputError");
    } catch (const quoin::scene_file::FileError& error) {
      PyErr_SetString(PyExc_OSError, error.what());
    }
  });
  python::bind_shapes(module);
  python::bind_pairs(module);
  python::bind_moving(module);
  python::bind_finder(module);
  python::bind_simulation(module);
  python::bind_equilibrium(module);
  refuse_new(module);
}
