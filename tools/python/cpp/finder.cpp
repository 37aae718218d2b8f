// ContactFinder: arrays in, structured arrays out.
#include <pybind11/stl.h>

#include <quoin/geometry/contact_finder.hpp>

#include "arrays.hpp"
#include "rows.hpp"
#include "shapes.hpp"

namespace quoin::python {
namespace {

/// What Python's filter threw, once the finder has returned.
class Filter {
 public:
  explicit Filter(py::function asked) : asked_(std::move(asked)) {}
  ~Filter() {
    const py::gil_scoped_acquire gil;
    asked_ = {};
    thrown_.reset();
  }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;

  bool operator()(int a, int b) {
    const py::gil_scoped_acquire gil;
    if (thrown_) return false;
    try {
      return asked_(a, b).cast<bool>();
    } catch (py::error_already_set& error) {
      thrown_.emplace(error);
    } catch (const py::cast_error&) {
      refused_ = true;
    }
    return false;
  }
  void rethrow() {
    if (std::exchange(refused_, false)) throw py::type_error("filter: it must return a bool");
    if (const auto error = std::exchange(thrown_, std::nullopt)) throw *error;
  }

 private:
  py::object asked_;
  bool refused_ = false;
  std::optional<py::error_already_set> thrown_;
};

class Finder {
 public:
  Finder(double reach, double tolerance, int threads, double coordinate_rounding)
      : finder_({.reach = reach,
                 .tolerance = tolerance,
                 .threads = threads,
                 .coordinate_rounding = coordinate_rounding}) {}

  int add(const ShapePointer& shape, const py::object& at, std::uint32_t category,
          std::uint32_t collides_with, bool moving) {
    const geometry::Placement place = placement(at);
    const Use use(busy_, kName);
    return finder_.add(shape, place, options(category, collides_with, moving));
  }

  py::array_t<int> add_all(const py::object& shapes, const py::object& at, std::uint32_t category,
                           std::uint32_t collides_with, bool moving) {
    const std::vector<geometry::Placement> places = placements(at);
    std::vector<ShapePointer> given;
    if (py::isinstance<geometry::Shape>(shapes)) {
      given.assign(places.size(), shapes.cast<ShapePointer>());
    } else {
      for (const py::handle shape : shapes) given.push_back(shape.cast<ShapePointer>());
    }
    require_equal(given.size(), places.size(), "shapes");
    py::array_t<int> handles(static_cast<py::ssize_t>(places.size()));
    const Use use(busy_, kName);
    for (std::size_t i = 0; i < places.size(); ++i) {
      handles.mutable_data()[i] =
          finder_.add(given[i], places[i], options(category, collides_with, moving));
    }
    return handles;
  }

  void move(int handle, const py::object& at) {
    const geometry::Placement place = placement(at);
    const Use use(busy_, kName);
    finder_.move(handle, place);
  }

  void move_all(const py::object& handles, const py::object& at) {
    const std::vector<int> which = indices(handles, "handles");
    const std::vector<geometry::Placement> places = placements(at);
    require_equal(which.size(), places.size(), "handles");
    const Use use(busy_, kName);
    for (std::size_t i = 0; i < which.size(); ++i) finder_.move(which[i], places[i]);
  }

  void remove(int handle) {
    const Use use(busy_, kName);
    finder_.remove(handle);
  }
  void replace_shape(int handle, const ShapePointer& shape) {
    const Use use(busy_, kName);
    finder_.replace_shape(handle, shape);
  }
  void set_options(int handle, std::uint32_t category, std::uint32_t collides_with, bool moving) {
    const Use use(busy_, kName);
    finder_.set_options(handle, options(category, collides_with, moving));
  }
  void set_reach(double reach, std::optional<int> handle) {
    const Use use(busy_, kName);
    handle ? finder_.set_reach(*handle, reach) : finder_.set_reach(reach);
  }
  void set_filter(const py::object& asked) {
    const Use use(busy_, kName);
    if (asked.is_none()) {
      filter_.reset();
      finder_.set_filter({});
      return;
    }
    if (!py::isinstance<py::function>(asked) && PyCallable_Check(asked.ptr()) == 0) {
      throw py::type_error("filter: it is not callable");
    }
    filter_ = std::make_shared<Filter>(py::reinterpret_borrow<py::function>(asked));
    finder_.set_filter([filter = filter_](int a, int b) { return (*filter)(a, b); });
  }

  bool contains(int handle) {
    const Use use(busy_, kName);
    return finder_.contains(handle);
  }
  int size() {
    const Use use(busy_, kName);
    return finder_.size();
  }
  py::array_t<double> placement_of(int handle) {
    const Use use(busy_, kName);
    return matrix(finder_.body(handle).placement());
  }
  int threads() const { return finder_.threads(); }

  py::array_t<ContactRow> find() {
    const Use use(busy_, kName);
    {
      py::gil_scoped_release released;
      finder_.find(contacts_);
    }
    if (filter_) filter_->rethrow();
    return rows(contacts_);
  }
  py::array_t<ContactRow> contacts_of(const py::object& handles) {
    const std::vector<int> which = indices(handles, "handles");
    const Use use(busy_, kName);
    std::vector<geometry::ContactPoint> contacts;
    {
      py::gil_scoped_release released;
      finder_.contacts_of(which, contacts);
    }
    if (filter_) filter_->rethrow();
    return rows(contacts);
  }
  py::array_t<PairRow> pairs() {
    const Use use(busy_, kName);
    return rows(finder_.pairs());
  }

 private:
  static constexpr const char* kName = "ContactFinder";

  static geometry::BodyOptions options(std::uint32_t category, std::uint32_t collides_with,
                                       bool moving) {
    return {.category = category,
            .collides_with = collides_with,
            .motion = moving ? geometry::BodyMotion::Moving : geometry::BodyMotion::Idle};
  }
  static void require_equal(std::size_t given, std::size_t places, const char* name) {
    if (given == places) return;
    throw geometry::InputError(std::string(name) + ": " + std::to_string(given) + " for " +
                               std::to_string(places) + " placements");
  }

  geometry::ContactFinder finder_;
  std::vector<geometry::ContactPoint> contacts_;
  std::shared_ptr<Filter> filter_;
  std::atomic_flag busy_{};
};

constexpr std::uint32_t kAll = ~std::uint32_t{0};

void bind_bodies(py::class_<Finder>& finder) {
  finder
      .def("add", &Finder::add, py::arg("shape").none(false), py::arg("placement") = py::none(),
           py::kw_only(), py::arg("category") = 1u, py::arg("collides_with") = kAll,
           py::arg("moving") = true,
           "Adds a body and returns its handle, a number that is never given again. A pair is "
           "tested when each body's `category` has a bit of what the other `collides_with`, and "
           "one of them is `moving`.")
      .def("add_all", &Finder::add_all, py::arg("shapes"), py::arg("placements"), py::kw_only(),
           py::arg("category") = 1u, py::arg("collides_with") = kAll, py::arg("moving") = true,
           "Adds bodies at placements (n, 4, 4) or (n, 3, 4), of one shape or a list of one for "
           "each; returns their handles (n,).")
      .def("move", &Finder::move, py::arg("handle"), py::arg("placement"))
      .def("move_all", &Finder::move_all, py::arg("handles"), py::arg("placements"),
           "Other placements (n, 4, 4) or (n, 3, 4) of the bodies `handles` (n,).")
      .def("remove", &Finder::remove, py::arg("handle"))
      .def("replace_shape", &Finder::replace_shape, py::arg("handle"),
           py::arg("shape").none(false), "Another shape in the same place.")
      .def("set_options", &Finder::set_options, py::arg("handle"), py::kw_only(),
           py::arg("category") = 1u, py::arg("collides_with") = kAll, py::arg("moving") = true)
      .def("set_reach", &Finder::set_reach, py::arg("reach"), py::arg("handle") = py::none(),
           "Reach of all pairs, or of one body, m, from the next find() on.")
      .def("set_filter", &Finder::set_filter, py::arg("filter"),
           "filter(a, b) -> bool is asked for each pair of near bodies; False leaves it out. None: "
           "no filter. What it raises find() raises.");
}

}  // namespace

void bind_finder(py::module_& module) {
  py::class_<Finder> finder(
      module, "ContactFinder", py::is_final(),
      "All contacts of many bodies. Keeps bodies under stable handles, the tree of their boxes and "
      "what is known of each pair: that changes the speed, never the answer. reach, tolerance, "
      "coordinate_rounding in m. Calls raise InputError naming the handle when it is none. find() "
      "releases the GIL.");
  finder.def(py::init<double, double, int, double>(), py::kw_only(), py::arg("reach") = 0.0,
             py::arg("tolerance") = 0.0, py::arg("threads") = 1,
             py::arg("coordinate_rounding") = 0.0);
  bind_bodies(finder);
  finder
      .def("find", &Finder::find,
           "All contact points up to the reach, sorted by key: fields as of contacts(), a and b "
           "handles, previous the row of the same contact in the last list, -1: new.")
      .def("contacts_of", &Finder::contacts_of, py::arg("handles"),
           "What find() would list of pairs with a body of `handles` (n,); previous is -1.")
      .def("pairs", &Finder::pairs,
           "Pairs in contact after the last find() and those that it ended: event (index in "
           "PAIR_EVENTS), status, type, gap, normal, area, first and count of their points.")
      .def("placement", &Finder::placement_of, py::arg("handle"), "(4, 4)")
      .def_property_readonly("threads", &Finder::threads)
      .def("__contains__", &Finder::contains)
      .def("__len__", &Finder::size);
}

}  // namespace quoin::python
