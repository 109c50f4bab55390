#pragma once

namespace pierce {

/// Gives a variable a value until the end of a block, whatever ends it, and then that type's
/// default.
template <class Variable, class Value>
class ForNow {
public:
    ForNow(Variable& variable, const Value& value) : variable_(variable) { variable_ = value; }
    ForNow(const ForNow&) = delete;
    ~ForNow() { variable_ = Value{}; }

private:
    Variable& variable_;
};

}  // namespace pierce
