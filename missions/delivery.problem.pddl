; The goal stands in the mission file.
(define (problem three-parcels)
  (:domain delivery)
  (:objects Home - place Depot - depot North East - customer p1 p2 p3 - parcel)
  (:init (at Home) (free)
         (in p1 Depot) (in p2 Depot) (in p3 Depot)
         (wants North p1) (wants North p2) (wants East p3))
  (:goal (and)))
