; Parcels are carried from a depot to the customers who want them, one at a time.
(define (domain delivery)
  (:requirements :strips :typing :negative-preconditions :equality)
  (:types place parcel - object
          depot customer - place)
  (:predicates (at ?p - place)                    ; where the vehicle is
               (free)                             ; the gripper holds nothing
               (has ?x - parcel)                  ; it holds this parcel
               (in ?x - parcel ?d - depot)        ; the parcel lies there
               (wants ?c - customer ?x - parcel)
               (delivered ?x - parcel))
  (:action move
    :parameters (?from ?to - place)
    :precondition (and (at ?from) (not (= ?from ?to)))
    :effect (and (at ?to) (not (at ?from))))
  (:action pick-up
    :parameters (?x - parcel ?d - depot)
    :precondition (and (at ?d) (in ?x ?d) (free))
    :effect (and (has ?x) (not (in ?x ?d)) (not (free))))
  (:action hand-over
    :parameters (?x - parcel ?c - customer)
    :precondition (and (at ?c) (has ?x) (wants ?c ?x))
    :effect (and (delivered ?x) (not (has ?x)) (free))))
