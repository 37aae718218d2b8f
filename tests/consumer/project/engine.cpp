// A small engine: tables, each a compound of a top and two legs, fall on each other. Contacts are
// solved by sequential impulses; a ray from above says what lies where.
#include <cstdio>
#include <map>
#include <memory>
#include <quoin/geometry.hpp>
#include <vector>

namespace geometry = quoin::geometry;
using geometry::Vector3;

struct Table {
  geometry::Placement place;
  Vector3 velocity = Vector3::Zero(), spin = Vector3::Zero();  // m/s, rad/s
};

constexpr double kStep = 0.01, kGravity = 9.81;  // s, m/s2
constexpr double kMass = 1.0, kInertia = 0.3;    // kg, kg m2: of all axes alike

/// One contact point between two tables; null: the ground.
struct Contact {
  Table *a, *b;
  Vector3 arm_a, arm_b, normal;
  double wanted, impulse = 0.0;  // m/s, N s

  static void push(Table* table, const Vector3& arm, const Vector3& impulse) {
    if (table == nullptr) return;
    table->velocity += impulse / kMass;
    table->spin += arm.cross(impulse) / kInertia;
  }
  static Vector3 velocity(const Table* table, const Vector3& arm) {
    return table == nullptr ? Vector3(0, 0, 0) : Vector3(table->velocity + table->spin.cross(arm));
  }
  static double inverse_mass(const Table* table, const Vector3& arm, const Vector3& normal) {
    return table == nullptr ? 0.0 : 1 / kMass + arm.cross(normal).squaredNorm() / kInertia;
  }
  void solve() {
    const double speed = normal.dot(velocity(b, arm_b) - velocity(a, arm_a));
    const double mass = inverse_mass(a, arm_a, normal) + inverse_mass(b, arm_b, normal);
    const double now = std::max(0.0, impulse + (wanted - speed) / mass);
    push(a, arm_a, -(now - impulse) * normal);
    push(b, arm_b, (now - impulse) * normal);
    impulse = now;
  }
};

int main() {
  const auto box = [](double x, double y, double z) {
    const Vector3 half = 0.5 * Vector3(x, y, z);
    return std::make_shared<const geometry::Shape>(geometry::make_box(-half, half));
  };
  const auto at = [](double x, double y, double z) {
    return geometry::Placement{geometry::Matrix3::Identity(), {x, y, z}};
  };
  geometry::ContactFinder finder({.reach = 0.02});
  const int ground =
      finder.add(box(20, 20, 1), at(0, 0, -0.5), {.motion = geometry::BodyMotion::Idle});
  const auto leg = box(0.2, 1, 0.8);
  const std::vector<geometry::CompoundPart> parts{
      {box(2, 1, 0.2), {}}, {leg, at(-0.9, 0, -0.5)}, {leg, at(0.9, 0, -0.5)}};
  std::map<int, Table> tables;  // by handle
  for (int k = 0; k < 5; ++k) {
    const geometry::Placement place = at(0.02 * k, 0.01 * k, 1.2 + 1.3 * k);
    tables[finder.add_compound(parts, place)] = {place};
  }
  const auto table_of = [&](int handle) {
    return handle == ground ? nullptr : &tables.at(finder.part_name(handle).compound);
  };

  std::vector<geometry::ContactPoint> points;
  for (double time = 0.0; time < 4.0; time += kStep) {
    finder.find(points);
    for (auto& [handle, table] : tables) table.velocity.z() -= kGravity * kStep;
    std::vector<Contact> contacts;
    for (const geometry::ContactPoint& p : points) {
      Contact contact{table_of(p.key.a), table_of(p.key.b), {}, {}, p.normal, 0.0};
      if (contact.a) contact.arm_a = p.point() - contact.a->place.translation;
      if (contact.b) contact.arm_b = p.point() - contact.b->place.translation;
      contact.wanted = -std::max(p.gap, 0.2 * p.gap) / kStep;
      contacts.push_back(contact);
    }
    for (int sweep = 0; sweep < 40; ++sweep)
      for (Contact& contact : contacts) contact.solve();
    for (auto& [handle, table] : tables) {
      const geometry::Motion motion{table.velocity * kStep, table.spin * kStep,
                                    table.place.translation};
      table.place = geometry::placement_at(table.place, motion, 1.0);
      finder.move(handle, table.place);
    }
  }

  double fastest = 0.0;
  for (const auto& [handle, table] : tables) fastest = std::max(fastest, table.velocity.norm());
  std::printf("%zu tables %s\n", tables.size(), fastest < 0.02 ? "rest" : "move");
  const auto hit = finder.nearest_hit({.origin = {0, 0, 10}, .direction = {0, 0, -1}});
  if (!hit) return 1;
  const geometry::PartName name = finder.part_name(hit->handle);
  std::printf("from above: part %d of compound %d at %.1f m\n", name.part, name.compound,
              hit->hit.point.z());
}
