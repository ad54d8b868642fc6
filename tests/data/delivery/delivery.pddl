; Parcels are carried from a depot to the customers who want them, one at a time.
(define (domain delivery)
  (:requirements :strips :typing :negative-preconditions :equality :conditional-effects
                 :universal-preconditions)
  (:types place parcel - object
          depot customer - place)
  (:predicates (at ?p - place)
               (free)
               (has ?x - parcel)
               (in ?x - parcel ?p - place)
               (wants ?c - customer ?x - parcel)
               (delivered ?x - parcel)
               (lit ?p - place))
  (:action move
    :parameters (?from ?to - place)
    :precondition (and (at ?from) (not (= ?from ?to)))
    :effect (and (at ?to) (not (at ?from))))
  (:action pick-up
    :parameters (?x - parcel ?p - place)
    :precondition (and (at ?p) (in ?x ?p) (free))
    :effect (and (has ?x) (not (in ?x ?p)) (not (free))))
  (:action drop
    :parameters (?x - parcel ?p - place)
    :precondition (and (at ?p) (has ?x))
    :effect (and (free) (not (has ?x)) (in ?x ?p)))
  (:action hand-over
    :parameters (?c - customer)
    :precondition (at ?c)
    :effect (forall (?x - parcel)
              (when (and (has ?x) (wants ?c ?x))
                    (and (delivered ?x) (not (has ?x)) (free))))))
