// The Python module quoin._quoin.
#include "arrays.hpp"

namespace {

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
  pybind11::register_exception<quoin::geometry::InputError>(module, "InputError",
                                                            PyExc_ValueError);
  python::bind_shapes(module);
  python::bind_pairs(module);
  python::bind_finder(module);
  refuse_new(module);
}
