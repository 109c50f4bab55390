#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <concepts>
#include <string>
#include <utility>

#include "casters.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// A value of an enumeration from itself or its name. Throws a ValueError that lists the names.
template <class E>
E choice(nb::handle given, const char* what) {
    if (!nb::isinstance<nb::str>(given)) {
        E value{};
        if (nb::try_cast(given, value)) return value;
    }
    const nb::object type = nb::borrow(nb::type<E>());
    const nb::object members = type.attr("__members__");
    if (nb::isinstance<nb::str>(given) && nb::cast<bool>(members.attr("__contains__")(given)))
        return nb::cast<E>(members[given]);
    std::string names;
    for (nb::handle name : members)
        names += (names.empty() ? "" : ", ") + nb::cast<std::string>(nb::str(name));
    throw nb::value_error((std::string(what) + ": expected one of " + names + ", got " +
                           nb::cast<std::string>(nb::repr(given)))
                              .c_str());
}

/// "Name(field=value, ...)" of the fields that a class lists.
std::string text_of(nb::handle record);
/// The same as a table for notebooks.
std::string html_of(nb::handle record);
/// Sets fields by name; a field called `self` is `self_`, as Python itself uses that name. Throws a
/// TypeError for a name that is no field.
void set_fields(nb::handle record, const nb::kwargs& values);

/// Binds a C++ struct as a class with fields. `with_init`: Python makes values, from fields by
/// name.
template <class T>
class Record {
public:
    Record(nb::module_& module, const char* name, const char* doc) : class_(module, name, doc) {
        class_.def("__repr__", [](nb::handle_t<T> self) { return text_of(self); });
        class_.def("_repr_html_", [](nb::handle_t<T> self) { return html_of(self); });
        if constexpr (std::copy_constructible<T>) {
            class_.def("__copy__", [](const T& self) { return T(self); });
            class_.def(
                "__deepcopy__", [](const T& self, nb::handle) { return T(self); }, nb::arg("memo"));
        }
    }
    ~Record() { class_.attr("fields") = nb::tuple(fields_); }
    Record(const Record&) = delete;
    Record& operator=(const Record&) = delete;

    template <class Value>
    Record& ro(const char* name, Value T::*member, const char* doc) {
        fields_.append(name);
        class_.def_ro(name, member, doc);
        return *this;
    }
    template <class Value>
    Record& rw(const char* name, Value T::*member, const char* doc) {
        fields_.append(name);
        if constexpr (std::is_enum_v<Value>)
            class_.def_prop_rw(
                name, [member](const T& self) { return self.*member; },
                [member, name](T& self, nb::object value) {
                    self.*member = choice<Value>(value, name);
                },
                doc);
        else
            class_.def_rw(name, member, doc);
        return *this;
    }
    template <class Get>
    Record& get(const char* name, Get value_of, const char* doc, const char* signature = nullptr) {
        fields_.append(name);
        if (signature == nullptr)
            class_.def_prop_ro(name, std::move(value_of), doc);
        else
            class_.def_prop_ro(name, std::move(value_of), nb::sig(signature), doc);
        return *this;
    }
    /// Python makes values with T's defaults, and fields by name.
    Record& with_init() {
        class_.def(
            "__init__",
            [](T* self, const nb::kwargs& fields) {
                const nb::object made = nb::cast(T());
                set_fields(made, fields);
                new (self) T(nb::cast<const T&>(made));
            },
            nb::arg("fields"), nb::sig("def __init__(self, **fields: object) -> None"),
            "All fields by name; those that are left out have their defaults.");
        class_.def("__getstate__", [](nb::handle_t<T> self) {
            nb::dict state;
            for (nb::handle field : nb::borrow(self.type().attr("fields")))
                state[field] = nb::getattr(self, field);
            return state;
        });
        class_.def(
            "__setstate__",
            [](T& self, const nb::dict& state) {
                const nb::object made = nb::cast(T());
                set_fields(made, nb::borrow<nb::kwargs>(state));
                new (&self) T(nb::cast<const T&>(made));
            },
            nb::arg("state"));
        if constexpr (std::equality_comparable<T>) {
            class_.def(
                "__eq__", [](const T& a, const T& b) { return a == b; }, nb::is_operator(),
                nb::arg("other"), nb::sig("def __eq__(self, other: object, /) -> bool"));
            class_.def("__hash__", [](const T&) -> Py_hash_t {
                throw nb::type_error("unhashable: its fields may change");
            });
        }
        return *this;
    }
    nb::class_<T>& bound() { return class_; }

private:
    nb::class_<T> class_;
    nb::list fields_;
};

}  // namespace pierce::python
