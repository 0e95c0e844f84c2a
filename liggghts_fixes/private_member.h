// A way to private members of LIGGGHTS' classes without a change to any header: an explicit instantiation may name them
// ([temp.spec.general]), so that a template which takes the member pointer as an argument, and whose friend returns it,
// hands it out.
//
//   namespace {
//   struct FixMap {
//     using type = std::map<...>* LAMMPS_NS::Modify::*;
//     friend type member(FixMap);
//   };
//   template struct PrivateMember<FixMap, &LAMMPS_NS::Modify::fix_map>;
//   }  // namespace
//   modify.*member(FixMap())
#pragma once

namespace {  // an instantiation must stand in the template's own namespace

template <class Tag, typename Tag::type Member>
struct PrivateMember {
  friend typename Tag::type member(Tag) { return Member; }
};

}  // namespace

/// Within a namespace without a name: object.*member(Name()) is the member `what`, a Type, of an Owner.
#define PRIVATE_MEMBER(Name, Owner, Type, what) \
  struct Name {                                 \
    using type = Type Owner::*;                 \
    friend type member(Name);                   \
  };                                            \
  template struct PrivateMember<Name, &Owner::what>
