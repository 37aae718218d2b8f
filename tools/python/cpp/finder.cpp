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
    if (py::isinstance<geometry::Shape>(shapes))
      given.assign(places.size(), shapes.cast<ShapePointer>());
    else
      for (const py::handle shape : shapes) given.push_back(shape.cast<ShapePointer>());
    require_equal(given.size(), places.size(), "shapes");
    py::array_t<int> handles(static_cast<py::ssize_t>(places.size()));
    const Use use(busy_, kName);
    for (std::size_t i = 0; i < places.size(); ++i) {
      handles.mutable_data()[i] =
          finder_.add(given[i], places[i], options(category, collides_with, moving));
    }
    return handles;
  }

  int add_compound(const py::object& parts, const py::object& at, std::uint32_t category,
                   std::uint32_t collides_with, bool moving) {
    std::vector<geometry::CompoundPart> given;
    for (const py::handle one : parts) {
      if (py::isinstance<geometry::Shape>(one)) {
        given.push_back({.shape = one.cast<ShapePointer>()});
        continue;
      }
      const HeldBody& body = one.cast<const HeldBody&>();
      given.push_back({.shape = body.shape, .placement = body.body.placement()});
    }
    const geometry::Placement place = placement(at);
    const Use use(busy_, kName);
    return finder_.add_compound(given, place, options(category, collides_with, moving));
  }
  py::tuple part_name(int handle) {
    const Use use(busy_, kName);
    const geometry::PartName name = finder_.part_name(handle);
    return py::make_tuple(name.compound, name.part);
  }

  py::object nearest_hit(const py::object& origin, const py::object& direction, double length,
                         std::uint32_t categories) {
    const geometry::Ray ray{vector3(origin, "origin"), vector3(direction, "direction"), length};
    const Use use(busy_, kName);
    const auto hit = finder_.nearest_hit(ray, {.categories = categories});
    return hit ? py::object(py::make_tuple(hit->handle, hit->hit)) : py::none();
  }
  py::list all_hits(const py::object& origin, const py::object& direction, double length,
                    std::uint32_t categories) {
    const geometry::Ray ray{vector3(origin, "origin"), vector3(direction, "direction"), length};
    const Use use(busy_, kName);
    std::vector<geometry::BodyHit> hits;
    finder_.all_hits(ray, hits, {.categories = categories});
    py::list result;
    for (const geometry::BodyHit& hit : hits) result.append(py::make_tuple(hit.handle, hit.hit));
    return result;
  }
  py::array_t<int> bodies_in_box(const py::object& min, const py::object& max,
                                 std::uint32_t categories) {
    const geometry::Box box{vector3(min, "min"), vector3(max, "max")};
    const Use use(busy_, kName);
    std::vector<int> found;
    finder_.bodies_in_box(box, found, {.categories = categories});
    return py::array_t<int>(static_cast<py::ssize_t>(found.size()), found.data());
  }
  py::array_t<int> bodies_at(const py::object& point, double tolerance, std::uint32_t categories) {
    const Vector3 place = vector3(point, "point");
    const Use use(busy_, kName);
    std::vector<int> found;
    finder_.bodies_at(place, tolerance, found, {.categories = categories});
    return py::array_t<int>(static_cast<py::ssize_t>(found.size()), found.data());
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
    if (!py::isinstance<py::function>(asked) && PyCallable_Check(asked.ptr()) == 0)
      throw py::type_error("filter: it is not callable");
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
      .def("add_compound", &Finder::add_compound, py::arg("parts"),
           py::arg("placement") = py::none(), py::kw_only(), py::arg("category") = 1u,
           py::arg("collides_with") = kAll, py::arg("moving") = true,
           "Adds Shapes, or Bodies placed in the compound's frame, that move as one, and returns "
           "the handle h of part 0, by which it is moved and removed; part k is h + k in contacts "
           "and hits. Parts are never tested against each other. len() counts parts.")
      .def("part_name", &Finder::part_name, py::arg("handle"),
           "(handle of the compound, part); a body by itself is part 0 of itself.")
      .def("move", &Finder::move, py::arg("handle"), py::arg("placement"))
      .def("move_all", &Finder::move_all, py::arg("handles"), py::arg("placements"),
           "Other placements (n, 4, 4) or (n, 3, 4) of the bodies `handles` (n,).")
      .def("remove", &Finder::remove, py::arg("handle"))
      .def("replace_shape", &Finder::replace_shape, py::arg("handle"), py::arg("shape").none(false),
           "Another shape in the same place.")
      .def("set_options", &Finder::set_options, py::arg("handle"), py::kw_only(),
           py::arg("category") = 1u, py::arg("collides_with") = kAll, py::arg("moving") = true)
      .def("set_reach", &Finder::set_reach, py::arg("reach"), py::arg("handle") = py::none(),
           "Reach of all pairs, or of one body, m, from the next find() on.")
      .def("set_filter", &Finder::set_filter, py::arg("filter"),
           "filter(a, b) -> bool is asked for each pair of near bodies; False leaves it out. None: "
           "no filter. What it raises find() raises.");
}

void bind_finder_queries(py::class_<Finder>& finder) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  finder
      .def(
          "nearest_hit", &Finder::nearest_hit, py::arg("origin"), py::arg("direction"),
          py::arg("length") = kInfinity, py::arg("categories") = kAll,
          "The first body of these categories that the ray origin + s direction, 0 <= s <= length, "
          "enters: (handle, RayHit) or None.")
      .def("all_hits", &Finder::all_hits, py::arg("origin"), py::arg("direction"),
           py::arg("length") = kInfinity, py::arg("categories") = kAll,
           "All of them, (handle, RayHit) of each, by s, then by handle.")
      .def("bodies_in_box", &Finder::bodies_in_box, py::arg("min"), py::arg("max"),
           py::arg("categories") = kAll,
           "Handles (n,) of the bodies whose axis-aligned boxes meet this one, m, ascending; of "
           "turned bodies the boxes are up to half a diameter wider than the bodies.")
      .def("bodies_at", &Finder::bodies_at, py::arg("point"), py::arg("tolerance") = 0.0,
           py::arg("categories") = kAll,
           "Handles (n,) of the bodies that contain a point within `tolerance`, m, ascending.");
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
  bind_finder_queries(finder);
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
